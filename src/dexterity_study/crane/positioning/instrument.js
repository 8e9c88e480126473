// Strokes and payload: the crane's sag, and where four methods put its loaded tip.

const COLORS = { compensation: "blue", direct: "orange", modular: "bluish green", inverseNetwork: "reddish purple" };

export function values(inputs, { modules: { crane }, data }) {
  const strokes = [inputs.s1, inputs.s2, inputs.s3], task = crane.task([strokes, inputs.payload]);
  const target = task.slice(0, 2), misses = {}, stopping = [];
  const off = tip => [tip[0] - target[0], tip[1] - target[1]];
  for (const [name, label] of Object.entries(data.methods)) {
    const tip = driven(crane, task, name);
    misses[name] = tip ? off(tip) : null;
    if (tip && tip[2]) stopping.push(label[0]);
  }
  const [sagX, sagY] = off(crane.driven([task, strokes]));
  const distances = Object.entries(misses).map(([name, miss]) => [name, miss ? Math.hypot(...miss) : NaN]);
  return {
    ...Object.fromEntries(distances),
    misses, sagX, sagY,
    x: target[0],
    y: target[1],
    sag: Math.hypot(sagX, sagY),
    stopped: stopping.length ? `method ${stopping.join(", ")}` : "none",
    bars: crane.bars([strokes, inputs.payload, data.magnified[inputs.magnified]]),
  };
}

// Tip of the loaded crane after a method, or null where the method has no answer.
function driven(crane, task, name) {
  try {
    return crane.driven([task, crane[name](task)]);
  } catch (error) {
    if (error instanceof RangeError) return null;
    throw error;
  }
}

export function draw(outputs, inputs, { stages: { side, near }, data, modules: { crane } }) {
  const [rigid, loaded] = outputs.bars, parts = crane.about.parts, target = [outputs.x, outputs.y];
  const width = part => ({ pillar: 7, "lift arm": 6, "jib arm": 5, extension: 3.5, cylinders: 2, linkage: 2 })[part];
  side.line([[side.extent[0], 0], [side.extent[1], 0]], "rule", { width: 1 });
  for (const { part, points } of joined(rigid, parts)) side.line(points, "muted", { width: 0.45 * width(part) });
  for (const { part, points } of joined(loaded, parts)) {
    side.line(points, part === "cylinders" ? "vermillion" : "text", { width: width(part) });
  }
  const tip = loaded[parts.lastIndexOf("extension", parts.indexOf("cylinders"))][1];
  side.line([target, tip], "vermillion", { width: 1.5, dash: "4 3" });
  side.dot(tip, "vermillion", 3 + Math.sqrt(inputs.payload) / 4);
  side.ruler(1, `1 m; sag drawn ${inputs.magnified}`);
  side.handle("tip", target);

  const reached = Object.values(outputs.misses).filter(Boolean).map(miss => Math.hypot(...miss));
  const ring = ringOf(Math.max(outputs.sag, ...reached.sort((a, b) => a - b).slice(0, 3)));
  for (const share of [0.5, 1]) {
    near.line(circle(share), "rule", { width: 1.5, closed: true });
    near.text([0, share], `${Number((1000 * share * ring).toPrecision(2))} mm`, { down: -3, color: "muted" });
  }
  near.line([[-0.07, 0], [0.07, 0]], "text");
  near.line([[0, -0.07], [0, 0.07]], "text");
  point(near, [outputs.sagX, outputs.sagY], ring, "vermillion", "0");
  for (const [name, miss] of Object.entries(outputs.misses)) {
    if (miss) point(near, miss, ring, COLORS[name], data.methods[name][0]);
  }
}

export function drag(handle, position, inputs, { modules: { crane } }) {
  for (const reach of [() => crane.reach([position, inputs.s3]), () => crane.leastReach(position)]) {
    try {
      const [s1, s2, s3, within] = reach();
      if (within) return { s1, s2, s3 };
    } catch (error) {
      if (!(error instanceof RangeError)) throw error;
    }
  }
  return {};
}

// Bars of a part that follow one another as one line.
function joined(bars, parts) {
  const lines = [];
  bars.forEach(([from, to], i) => {
    const last = lines.at(-1), end = last && last.points.at(-1);
    if (last && last.part === parts[i] && end[0] === from[0] && end[1] === from[1]) last.points.push(to);
    else lines.push({ part: parts[i], points: [from, to] });
  });
  return lines;
}

// Radius [m] of the outer ring: 1, 2 or 5 times a power of ten.
function ringOf(largest) {
  const power = 10 ** Math.floor(Math.log10(Math.max(largest, 1e-6)));
  return [1, 2, 5, 10].map(factor => factor * power).find(radius => radius >= largest);
}

// A tip beside its target; one beyond the outer ring is drawn at its edge, hollow.
function point(stage, [x, y], ring, color, name) {
  const size = Math.hypot(x, y) / ring, share = size > 1.12 ? 1.12 / size : 1, place = [x / ring * share, y / ring * share];
  stage.line([[0, 0], place], color, { width: 1.5, dash: size > 1.12 ? "4 3" : "" });
  stage.dot(place, color, 5);
  stage.text(place, name, { right: 9, down: -5 });
}

function circle(radius) {
  return Array.from({ length: 72 }, (_, i) => [radius * Math.cos(i * Math.PI / 36), radius * Math.sin(i * Math.PI / 36)]);
}
