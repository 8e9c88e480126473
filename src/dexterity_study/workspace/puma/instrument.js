// The instrument of part III: links and a pose; the exact rule, two networks, and a section of the workspace.

// Position of a place in the section, in the plane of the first axis at the pose's azimuth.
function position({ azimuth }, radius, height) {
  return [radius * Math.cos(azimuth), radius * Math.sin(azimuth), height];
}

function pose(inputs, radius, height, { free }) {
  return free.pose([...position(inputs, radius, height), inputs.turnx, inputs.turny, inputs.turnz]);
}

function linksOf(inputs, data) {
  return data.links.map(name => inputs[name]);
}

// Centres of the cells of the section; radii are negative beyond the axis.
function centres({ extent: [left, right, bottom, top], cell }) {
  const between = (low, high) => Array.from({ length: Math.round((high - low) / cell) }, (_, i) => low + (i + 0.5) * cell);
  return { xs: between(left, right), ys: between(bottom, top) };
}

let last = { key: "", map: null };

// What rule and network say of the cells of the section, row by row; it does not depend on where the tool is.
function section({ radius, height, ...inputs }, context) {
  const key = JSON.stringify(inputs);
  if (last.key !== key) last = { key, map: classified(inputs, context) };
  return last.map;
}

function classified(inputs, { modules, data }) {
  const links = linksOf(inputs, data), { xs, ys } = centres(data), network = modules[data.networks[inputs.network]];
  const turned = pose(inputs, 0, 0, modules), truth = [], guess = [], trained = [];
  for (const height of ys) {
    for (const radius of xs) {
      const place = position(inputs, radius, height);
      const T = turned.map((row, i) => (i < 3 ? [row[0], row[1], row[2], place[i]] : row));
      truth.push(modules.arm.reachable(links, place));
      guess.push(network.confidence(links, T) >= data.threshold);
      trained.push(modules.space.contains([...links, ...place]));
    }
  }
  return { xs, ys, truth, guess, trained };
}

export function values(inputs, context) {
  const { modules, data } = context, links = linksOf(inputs, data), { radius, height } = inputs;
  const place = position(inputs, radius, height), T = pose(inputs, radius, height, modules);
  const isReached = modules.arm.reachable(links, place), map = section(inputs, context);
  const count = holds => map.truth.filter((truth, i) => map.trained[i] && holds(truth, map.guess[i])).length;
  const share = holds => count(holds) / count(() => true);
  const outputs = {
    map,
    reach: isReached ? "yes" : "no",
    margin: Math.min(...modules.arm.margins([links, place])),
    w: isReached ? modules.arm.manipulability([links, T]) : NaN,
    trained: modules.space.contains([...links, ...place]) ? "yes" : "no",
    invented: share((truth, guess) => guess && !truth),
    missed: share((truth, guess) => truth && !guess),
  };
  for (const name of Object.values(data.networks)) outputs[name] = modules[name].confidence(links, T);
  return outputs;
}

export function draw({ map, reach }, inputs, { modules, data, stages: { section: stage } }) {
  const { xs, ys, truth, guess, trained } = map, { radius, height, azimuth } = inputs, [, , bottom, top] = data.extent;
  const classes = [[true, true, "sky blue"], [false, true, "vermillion"], [true, false, "reddish purple"]];
  for (const [isReached, isGuessed, color] of classes) {
    for (const isTrained of [true, false]) {
      const member = i => truth[i] === isReached && guess[i] === isGuessed && trained[i] === isTrained;
      stage.cells(xs, ys, (column, row) => member(row * xs.length + column), color, isTrained ? 0.8 : 0.35);
    }
  }
  const side = data.trained, width = side / Math.max(Math.abs(Math.cos(azimuth)), Math.abs(Math.sin(azimuth)));
  stage.line([[-width, -side], [width, -side], [width, side], [-width, side]], "muted", { width: 1.5, dash: "5 4", closed: true });
  stage.line([[0, bottom], [0, top]], "muted", { width: 1, dash: "10 3 2 3" });
  if (reach === "yes") {
    const points = modules.arm.origins([linksOf(inputs, data), pose(inputs, radius, height, modules)]);
    const flat = points.map(([x, y, z]) => [x * Math.cos(azimuth) + y * Math.sin(azimuth), z]);
    stage.line(flat, "orange", { width: 5 });
    for (const point of flat) stage.dot(point, "text", 3.5);
  }
  stage.ruler(0.2, "0.2 m");
  stage.handle("tool", [radius, height]);
}

export function drag(grip, [radius, height]) {
  return { radius, height };
}
