// The docking pose: what the arm is worth over the task area, and a view from above.

export function values(inputs, { modules, data }) {
  const arm = modules[inputs.arm], pose = [inputs.x, inputs.y, inputs.z, inputs.heading];
  const map = data.points.map(point => arm.manipulability([pose, point]));
  const dead = data.points.filter((_, i) => map[i] === 0);
  const middle = [0, 1].map(axis => dead.reduce((sum, point) => sum + point[axis], 0) / dead.length);
  const corners = Object.entries(data.corners).map(([name, point]) => [name, arm.manipulability([pose, point])]);
  return {
    ...Object.fromEntries(corners),
    map,
    area: arm.areaManipulability(pose),
    dead: dead.length / map.length,
    place: dead.length ? middle.map(metres => `${metres.toFixed(2)} m`.replace("-", "−")).join(", ") : "none",
    median: [...map].sort((a, b) => a - b)[(map.length - 1) / 2],
    distance: arm.distance(pose),
    fitness: arm.fitness(pose),
    allowed: arm.allows(pose) ? "yes" : "no",
    base: arm.placed([pose, 0, 0, 0]),
    bow: arm.placed([pose, 0.35, 0, 0]),
    vehicle: data.vehicle.map(point => arm.placed([pose, point])),
  };
}

export function draw(outputs, inputs, { stages: { top, area }, data }) {
  const [right, ahead] = data.block, [a, b, c, d] = outputs.vehicle;
  top.line(rectangle(right, ahead), "muted", { width: 1.5, fill: 0.08 });
  zeros(top, outputs, data);
  top.line(rectangle(data.half, data.half), "text", { width: 1.5, closed: true });
  top.line([a, b, d, c], "blue", { fill: 0.12 });
  top.line([outputs.base, outputs.bow], "blue", { width: 3 });
  top.ruler(0.5, "0.5 m");
  top.handle("base", outputs.base);
  top.handle("bow", outputs.bow, 9);

  heat(area, outputs, inputs, data);
  zeros(area, outputs, data);
  area.line(rectangle(data.half, data.half), "text", { width: 1.5, closed: true });
  for (const [name, point] of Object.entries(data.corners)) {
    area.dot(point, "text", 4);
    area.text(point, name, { right: Math.sign(point[0]) * 12, down: point[1] > 0 ? -6 : 15 });
  }
  const smallest = Math.min(...outputs.map), largest = Math.max(...outputs.map);
  if (smallest > 0) area.line(circle(data.points[outputs.map.indexOf(smallest)], 0.012), "orange", { width: 3, closed: true });
  const anywhere = data.largest[inputs.arm].toPrecision(2);
  area.text([0, -1.15 * data.half], `w up to ${largest.toPrecision(2)} m³ here, ${anywhere} m³ anywhere`);
}

export function drag(handle, [x, y], inputs) {
  return handle === "base" ? { x, y } : { heading: Math.atan2(y - inputs.y, x - inputs.x) };
}

// Cells of the map, in eight shades up to the largest w that the arm has anywhere.
function heat(stage, { map }, { arm }, { points, perSide, largest }) {
  const side = points.slice(0, perSide).map(point => point[1]);
  const shade = map.map(w => Math.ceil(8 * w / largest[arm]));
  for (let level = 1; level <= 8; ++level) {
    stage.cells(side, side, (column, row) => shade[column * perSide + row] === level, "bluish green", level / 8);
  }
}

// Cells where w is zero.
function zeros(stage, { map }, { points, perSide }) {
  const side = points.slice(0, perSide).map(point => point[1]);
  stage.cells(side, side, (column, row) => map[column * perSide + row] === 0, "vermillion", 0.75);
}

function rectangle(x, y) {
  return [[-x, -y], [x, -y], [x, y], [-x, y]];
}

function circle([x, y], radius) {
  return Array.from({ length: 24 }, (_, i) => [x + radius * Math.cos(i * Math.PI / 12), y + radius * Math.sin(i * Math.PI / 12)]);
}
