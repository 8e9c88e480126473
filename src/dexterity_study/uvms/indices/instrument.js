// The instrument of part I: reads twelve joint values, asks the exported modules, and draws two views.

const NETWORKS = ["FeedForward", "RadialBasis"];

// Views: the coordinates that go to the right and upwards, with signs, and the joint that each circle turns, from 0.
const VIEWS = {
  side: { right: [1, 1], up: [2, 1], turns: { nose: 3, elbow: 7, wrist: 8, tool: 10 } },
  top: { right: [1, 1], up: [0, -1], turns: { nose: 5, wrist: 6, tool: 9 } },
};

function seen({ right, up }, vector) {
  return [right[1] * vector[right[0]], up[1] * vector[up[0]]];
}

function joints(inputs, data) {
  return data.joints.map(name => inputs[name]);
}

function apply(T, point) {
  return [0, 1, 2].map(i => T[i][0] * point[0] + T[i][1] * point[1] + T[i][2] * point[2] + T[i][3]);
}

// Points that can be dragged.
function grips(q, { kinematics }) {
  const points = kinematics.points(q);
  return { vehicle: points[5], nose: points[6], elbow: points[8], wrist: points[12], tool: apply(kinematics.pose(q), [0, 0.3, 0]) };
}

export function values(inputs, { modules, data }) {
  const q = joints(inputs, data), outputs = { kciTool: modules.kciTool.value(q) };
  for (const name of ["w", "kci"]) {
    const exact = outputs[name] = modules[name].value(q);
    for (const kind of NETWORKS) {
      const value = outputs[name + kind] = modules[name + kind].value(q);
      outputs[name + kind + "Error"] = exact > 0 ? Math.abs(value / exact - 1) : NaN;
    }
    outputs[name + "Inside"] = modules[name + "Space"].contains(q) ? "yes" : "no";
  }
  const graded = data.indexOfTask[inputs.task] === "manipulability" ? "w" : "kci";
  outputs.taskIndex = graded === "w" ? "w" : "KCI";
  outputs.taskRank = data.samples[graded].filter(value => value < outputs[graded]).length / data.samples[graded].length;
  return outputs;
}

export function draw(outputs, inputs, { modules, data, stages }) {
  const q = joints(inputs, data), { kinematics } = modules;
  const links = kinematics.links(q), points = kinematics.points(q), J = kinematics.jacobian(q);
  const held = grips(q, modules), corners = box(data.vehicle).map(face => face.map(corner => apply(links[5], corner)));
  for (const [name, stage] of Object.entries(stages)) {
    const view = VIEWS[name], flat = point => seen(view, point);
    for (const face of corners) stage.line(face.map(flat), "muted", { width: 1, fill: 0.04 });
    stage.ellipse(flat(held.wrist), rows(view, J).map(row => row.map(value => data.ellipseScale * value)), "blue", { fill: 0.12 });
    stage.dot(flat(data.taskPoint), "vermillion", 4);
    stage.text(flat(data.taskPoint), "task", { down: 16 });
    stage.line([points[6], points[8], points[12]].map(flat), "orange", { width: 5 });
    stage.line([held.wrist, held.tool].map(flat), "text", { width: 3 });
    for (const point of [points[6], points[8], points[12]]) stage.dot(flat(point), "text", 3.5);
    stage.ruler(0.5, "0.5 m; speeds of the ellipse: " + 0.5 / data.ellipseScale + " m/s");
    for (const grip of ["vehicle", ...Object.keys(view.turns)]) stage.handle(grip, flat(held[grip]));
  }
}

export function drag(grip, target, inputs, { modules, data }, drawing) {
  const view = VIEWS[drawing], q = joints(inputs, data);
  if (grip === "vehicle") {
    return Object.fromEntries([view.right, view.up].map(([axis, sign], i) => [data.joints[axis], sign * target[i]]));
  }
  const joint = view.turns[grip];
  const missed = angle => {
    const [x, y] = seen(view, grips(q.with(joint, angle), modules)[grip]);
    return Math.hypot(x - target[0], y - target[1]);
  };
  return { [data.joints[joint]]: nearest(missed) };
}

// Angle at which something is least: the best of every few degrees, and then between its neighbours.
function nearest(missed) {
  const step = Math.PI / 36;
  let best = -Math.PI;
  for (let i = -36; i <= 36; i++) if (missed(i * step) < missed(best)) best = i * step;
  let [low, high] = [best - step, best + step];
  for (let i = 0; i < 24; i++) {
    const third = (high - low) / 3;
    if (missed(low + third) < missed(high - third)) high -= third;
    else low += third;
  }
  return (low + high) / 2;
}

// Rows of a Jacobian that a view shows.
function rows({ right, up }, J) {
  return [right, up].map(([axis, sign]) => J[axis].map(value => sign * value));
}

// Six faces of a box about the origin.
function box(size) {
  const corner = signs => signs.map((sign, i) => sign * size[i] / 2);
  return [0, 1, 2].flatMap(axis => [-1, 1].map(side => [[-1, -1], [-1, 1], [1, 1], [1, -1]].map(([a, b]) => {
    const signs = [a, b];
    signs.splice(axis, 0, side);
    return corner(signs);
  })));
}
