"use strict";
const pane = document.getElementById("pane"), panel = document.getElementById("panel");
const hint = document.getElementById("hint"), legend = document.getElementById("legend");
let onScreen = false, loading = null, labels = [], held = false, panelOf = null;
window.viewer = null;

function say(text) {
  const note = document.getElementById("note");
  note.textContent = text;
  note.hidden = false;
  document.title = "scene-still";
}

// ---- the page around ------------------------------------------------------------------------------

// Calls with the document of the page around, where there is one that may be looked at.
function withPage(action) {
  try { return action(parent.document); } catch (error) { return undefined; }
}

// Black and the lines of the floor as they are drawn on a dark ground.
const ON_DARK = new Map([[0x000000, 0xd5dae0], [0x1f2933, 0xd5dae0], [0xc5cdd6, 0x3a444f]]);
const isDark = () => document.documentElement.dataset.theme === "dark" && !matchMedia("print").matches;

function followTheme() {
  const system = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
  document.documentElement.dataset.theme = withPage(({ documentElement, body }) => {
    const inNotebook = { true: "light", false: "dark" }[body.dataset.jpThemeLight];
    return documentElement.dataset.theme || inNotebook;
  }) || system;
  for (const swatch of legend.querySelectorAll("i")) {
    const color = parseInt(swatch.dataset.color.slice(1), 16), drawn = isDark() && ON_DARK.get(color);
    swatch.style.background = drawn ? "#" + drawn.toString(16).padStart(6, "0") : swatch.dataset.color;
  }
  if (window.viewer) recolor();
}

function recolor() {
  viewer.scene.traverse(({ material }) => {
    if (!material || !material.color) return;
    if (material.userData.color === undefined) material.userData.color = material.color.getHex();
    const color = material.userData.color, drawn = isDark() && ON_DARK.get(color);
    material.color.setHex(drawn || color);
  });
  viewer.set_dirty();
}

followTheme();
for (const media of ["print", "(prefers-color-scheme: dark)"]) matchMedia(media).addEventListener("change", followTheme);
withPage(({ documentElement, body }) => {
  const observer = new MutationObserver(followTheme);
  observer.observe(documentElement, { attributes: true, attributeFilter: ["data-theme"] });
  observer.observe(body, { attributes: true, attributeFilter: ["data-jp-theme-light"] });
});

// ---- the viewer's script and the scene's commands -------------------------------------------------

async function inflate(base64) {
  const packed = new Blob([Uint8Array.from(atob(base64), letter => letter.charCodeAt(0))]);
  const stream = packed.stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

// The book's root is known to the page around; a notebook has none, but may have the script inside.
const bookRoot = withPage(page => page.documentElement.dataset.content_root);
const inlined = document.getElementById("inlined-viewer").textContent;

async function loadViewer() {
  const script = document.createElement("script");
  if (inlined) {
    script.textContent = new TextDecoder().decode(await inflate(inlined));
    document.head.append(script);
    return;
  }
  await new Promise((resolve, reject) => {
    script.src = bookRoot + "_static/meshcat/main.min.js";
    script.onload = resolve;
    script.onerror = () => reject(new Error("The 3-D viewer was not found"));
    document.head.append(script);
  });
}

async function unpack() {
  const bytes = new Uint8Array(await inflate(document.getElementById("commands").textContent));
  const commands = [], numbers = new DataView(bytes.buffer);
  for (let at = 0; at < bytes.length;) {
    const end = at + 4 + numbers.getUint32(at, true);
    commands.push(bytes.subarray(at + 4, end));
    at = end;
  }
  return commands;
}

// ---- what can be drawn and moved ------------------------------------------------------------------

// Straight segments of a width in pixels, wherever the camera is.
function thickLine(points, pixels, color, paneSize) {
  const { THREE } = MeshCat, here = [], there = [], side = [], index = [];
  points.slice(1).forEach((end, i) => {
    for (const [own, other] of [[points[i], end], [end, points[i]]]) {
      here.push(...own, ...own);
      there.push(...other, ...other);
      side.push(-1, 1);
    }
    index.push(4 * i, 4 * i + 1, 4 * i + 2, 4 * i, 4 * i + 2, 4 * i + 3);
  });
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(here, 3));
  geometry.setAttribute("other", new THREE.Float32BufferAttribute(there, 3));
  geometry.setAttribute("side", new THREE.Float32BufferAttribute(side, 1));
  geometry.setIndex(index);
  const material = new THREE.ShaderMaterial({
    uniforms: { color: { value: new THREE.Color(color) }, pixels: { value: pixels }, pane: paneSize },
    vertexShader: `
      uniform float pixels; uniform vec2 pane; attribute vec3 other; attribute float side;
      void main() {
        vec4 here = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
        vec4 there = projectionMatrix * modelViewMatrix * vec4(other, 1.0);
        vec2 way = (there.xy / there.w - here.xy / here.w) * pane;
        way = length(way) > 1e-6 ? normalize(way) : vec2(1.0, 0.0);
        here.xy += (side * vec2(-way.y, way.x) - way) * pixels / pane * here.w;
        gl_Position = min(here.w, there.w) > 0.0 ? here : vec4(2.0, 2.0, 2.0, 1.0);
      }`,
    fragmentShader: "uniform vec3 color; void main() { gl_FragColor = vec4(color, 1.0); }",
    side: THREE.DoubleSide,
  });
  material.color = material.uniforms.color.value;
  return new THREE.Mesh(geometry, material);
}

function moveJoint(value, { node, kind }) {
  if (kind === "prismatic") viewer.set_property(node, "position", [0, 0, value]);
  else viewer.set_property(node, "quaternion", [0, 0, Math.sin(value / 2), Math.cos(value / 2)]);
}

// Puts bodies where they are for a slider's value, by the share of the way between two of the values it knows.
function moveBodies(value, { values, bodies }) {
  let next = 1;
  while (next < values.length - 1 && values[next] < value) next++;
  const share = (value - values[next - 1]) / (values[next] - values[next - 1]);
  const between = rows => rows[next - 1].map((number, i) => number + share * (rows[next][i] - number));
  for (const { node, positions, turns, stretches } of bodies) {
    const turn = between(turns), length = Math.hypot(...turn);
    viewer.set_property(node, "position", between(positions));
    viewer.set_property(node, "quaternion", turn.map(number => number / length));
    viewer.set_property(node, "scale", between(stretches));
  }
}

function move(slider, value) {
  slider.now = value;
  if (slider.joint) moveJoint(value, slider.joint);
  else moveBodies(value, slider.table);
  viewer.set_dirty();
}

// ---- controls -------------------------------------------------------------------------------------

// The panel outlives the viewer, which comes and goes as the scene is scrolled.
function makePanel(sliders, spans) {
  const { duration } = viewer.animator, controls = document.getElementById("controls");
  const reset = element("button", { type: "button" }, "Reset"), resets = [() => viewer.reset_view()], made = [];
  let playing = !matchMedia("(prefers-reduced-motion: reduce)").matches, time = null;
  let play = null, moving = null;

  function setPlaying(now) {
    playing = now;
    play.textContent = playing ? "Pause" : "Play";
    if (playing) viewer.animator.play();
    else viewer.animator.pause();
  }

  function showTime(now) {
    time.show(now);
    const names = new Set(spans.filter(({ start, end }) => start <= now && now < end).map(({ name }) => name));
    const all = names.size > 3 ? names.size + " joints" : [...names].join(", ");
    moving.textContent = spans.length ? "Moves: " + (all || "nothing") : "";
    for (const label of labels) label.element.classList.toggle("moving", names.size <= 3 && names.has(label.text));
  }

  if (duration > 0) {
    play = element("button", { type: "button" });
    play.addEventListener("click", () => setPlaying(!playing));
    moving = element("span", { id: "moving" });
    time = makeSlider({ label: "Time [s]", value: 0, min: 0, max: duration, step: 0.01 }, now => {
      setPlaying(false);
      viewer.animator.seek(now);
      showTime(now);
    });
    resets.push(() => { viewer.animator.seek(0); showTime(0); });
    controls.append(play, " ", reset, time.row, moving);
  }
  for (const slider of sliders) {
    const control = makeSlider(slider, value => move(slider, value));
    resets.push(() => { control.show(slider.value); move(slider, slider.value); });
    made.push(control);
  }
  if (made.length) controls.append(makeGroup("Sliders that move the scene", made, duration > 0 ? 5 : 7));
  if (!duration) controls.append(reset);
  reset.addEventListener("click", () => { for (const each of resets) each(); });
  panel.hidden = !duration && !sliders.length;
  document.body.classList.toggle("playback", !sliders.length);
  panel.querySelector("summary").textContent = `Sliders (${sliders.length})`;
  panel.open = !sliders.length || innerWidth > 540;
  return {
    sliders: made.length,
    // Brings a viewer that has just been opened to where the reader left the scene.
    resume() {
      for (const slider of sliders) if (slider.now !== undefined) move(slider, slider.now);
      if (!time) return;
      viewer.animator.display_progress = showTime;
      if (time.input.valueAsNumber > 0) viewer.animator.seek(time.input.valueAsNumber);
      setPlaying(playing);
    },
  };
}

// A touch or the wheel scrolls the page until the reader takes hold of the scene.
function hold(now) {
  held = now;
  pane.style.touchAction = held ? "none" : "pan-y pinch-zoom";
  hint.textContent = held ? "tap beside the scene to scroll" : "tap to turn";
  hint.hidden = !window.viewer || !matchMedia("(pointer: coarse)").matches;
  if (window.viewer) viewer.controls.enableZoom = held;
}

function letGo(event) {
  if (!pane.contains(event.target)) hold(false);
}

pane.addEventListener("pointerdown", ({ pointerType }) => {
  const byTouch = pointerType === "touch";
  if (window.viewer) viewer.controls.enabled = held || !byTouch;
  if (!byTouch) hold(true);
}, true);
pane.addEventListener("click", () => hold(true));
document.documentElement.addEventListener("mouseleave", () => hold(false));
document.addEventListener("pointerdown", letGo);
withPage(page => page.addEventListener("pointerdown", letGo));
addEventListener("pagehide", event => {
  if (!event.persisted) withPage(page => page.removeEventListener("pointerdown", letGo));
});

// Arrow keys turn the scene, plus and minus go nearer and away.
function turnByKeys(event) {
  const way = { ArrowLeft: [-0.1, 0, 1], ArrowRight: [0.1, 0, 1], ArrowUp: [0, -0.1, 1], ArrowDown: [0, 0.1, 1],
                "+": [0, 0, 0.9], "-": [0, 0, 1 / 0.9] }[event.key];
  if (!way || event.ctrlKey || event.metaKey) return;
  event.preventDefault();
  const { camera, controls } = viewer, offset = camera.position.clone().sub(controls.target);
  const sphere = new MeshCat.THREE.Spherical().setFromVector3(offset);
  sphere.theta += way[0];
  sphere.phi = Math.min(Math.max(sphere.phi + way[1], 0.01), Math.PI - 0.01);
  sphere.radius *= way[2];
  camera.position.setFromSpherical(sphere).add(controls.target);
  controls.dispatchEvent({ type: "start" });
  viewer.set_dirty();
}

// ---- opening and closing --------------------------------------------------------------------------

// Moves a label off another one, the shorter way.
function giveWay(spot, label, other) {
  const x = spot.x - other.x, y = spot.y - other.y;
  const across = (label.width + other.width) / 2 - Math.abs(x), along = (label.height + other.height) / 2 - Math.abs(y);
  if (across <= 0 || along <= 0) return;
  if (across < along) spot.x += x < 0 ? -across : across;
  else spot.y += y < 0 ? -along : along;
}

function openViewer(commands) {
  const viewer = window.viewer = new MeshCat.Viewer(pane), meshcat = MeshCat.Viewer.prototype;
  const paneSize = { value: new MeshCat.THREE.Vector2(1, 1) }, sliders = [];
  let view = null, turned = false, spans = [];
  // meshcat's own panel has nothing that a reader needs.
  viewer.gui.domElement.remove();

  function look() {
    const camera = viewer.camera, [x, y, z] = view.half_extent;
    const slope = Math.tan(view.field_of_view * Math.PI / 360);
    const distance = z + Math.max(y, x / camera.aspect) / slope;
    const place = i => view.target[i] + distance * view.back[i];
    // The world's z is up, the viewer's y.
    viewer.controls.target.set(view.target[0], view.target[2], -view.target[1]);
    camera.position.set(place(0), place(2), -place(1));
    Object.assign(camera, { fov: view.field_of_view, near: distance / 100, far: distance * 100 });
    viewer.controls.update();
  }

  function placeLabels() {
    const placed = [];
    for (const label of labels) {
      const at = label.anchor.getWorldPosition(label.anchor.position.clone()).project(viewer.camera);
      const spot = { x: (at.x + 1) / 2 * pane.clientWidth, y: (1 - at.y) / 2 * pane.clientHeight };
      for (const other of [...placed, ...placed, ...placed]) giveWay(spot, label, other);
      placed.push({ ...label, ...spot });
      label.element.style.transform = "translate(" + spot.x + "px," + spot.y + "px) translate(-50%,-50%)";
      label.element.hidden = at.z > 1;
    }
  }

  const split = path => path.split("/").filter(name => name);
  const added = {
    set_view(command) { view = command; },
    set_path({ path, points, pixels, color }) {
      viewer.set_object(split(path), thickLine(points, pixels, color, paneSize));
    },
    set_label({ path, text }) {
      const span = element("span", { className: "label" }, text);
      pane.append(span);
      const anchor = viewer.scene_tree.find(split(path)).object;
      labels.push({ element: span, text, anchor, width: span.offsetWidth + 4, height: 0.8 * span.offsetHeight });
    },
    set_slider(command) { sliders.push(command); },
    set_moving(command) { spans = command.spans; },
  };
  viewer.handle_command = command => (added[command.type] || meshcat.handle_command.bind(viewer))(command);
  viewer.render = () => { meshcat.render.call(viewer); placeLabels(); };
  viewer.set_3d_pane_size = () => {
    paneSize.value.set(pane.clientWidth, pane.clientHeight);
    meshcat.set_3d_pane_size.call(viewer, pane.clientWidth, pane.clientHeight);
    if (!turned) look();
  };

  for (const command of commands) viewer.handle_command_bytearray(command);
  recolor();
  viewer.reset_view = () => { turned = false; viewer.set_3d_pane_size(); };
  panelOf = panelOf || makePanel(sliders, spans);
  panelOf.resume();
  viewer.set_3d_pane_size();
  viewer.controls.addEventListener("start", () => { turned = true; });
  hold(false);
  const canvas = viewer.renderer.domElement, { alt } = document.getElementById("still");
  const keys = "Arrow keys turn the scene, plus and minus zoom.";
  const follow = panelOf.sliders ? ` ${panelOf.sliders} sliders follow, which move it.` : "";
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "application");
  canvas.setAttribute("aria-label", `${alt}. ${keys}${follow}`);
  canvas.addEventListener("keydown", turnByKeys);
  canvas.addEventListener("webglcontextlost", () => { if (window.viewer === viewer) closeViewer(); });
  viewer.render();
}

function closeViewer() {
  const viewer = window.viewer;
  window.viewer = null;
  document.body.classList.remove("live");
  document.title = "scene-idle";
  hold(false);
  for (const label of labels) label.element.remove();
  labels = [];
  viewer.controls.dispose();
  viewer.gui.destroy();
  viewer.renderer.forceContextLoss();
  viewer.renderer.dispose();
  viewer.renderer.domElement.remove();
  // meshcat's listeners outlive it: leave them nothing to do and nothing to hold.
  for (const key of Object.keys(viewer)) delete viewer[key];
  viewer.animate = viewer.set_3d_pane_size = () => {};
}

async function start() {
  try {
    loading = loading || Promise.all([unpack(), loadViewer()]);
    const [commands] = await loading;
    if (!onScreen || window.viewer) return;
    openViewer(commands);
    document.body.classList.add("live");
    document.title = "scene-ready";
  } catch (error) {
    if (window.viewer) closeViewer();
    say("Still picture, because the scene could not start: " + error.message);
  }
}

if (bookRoot === undefined && !inlined) {
  say("Still picture: dexterity.scenes.standalone lets the scene move in a notebook.");
} else {
  // Browsers draw few scenes at a time: each has a viewer only while it is on screen.
  new IntersectionObserver(entries => {
    onScreen = entries[entries.length - 1].isIntersecting;
    if (onScreen) setTimeout(start, 150);
    else if (window.viewer) closeViewer();
  }).observe(pane);
  new ResizeObserver(() => { if (window.viewer) window.viewer.set_3d_pane_size(); }).observe(pane);
}
