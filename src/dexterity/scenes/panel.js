// Controls of a scene: native sliders with a label and a value each, which arrow keys move.

function element(tag, properties = {}, ...content) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...content);
  return made;
}

// A slider whose `moved(value)` is called when the reader moves it; `show(value)` moves it without a call.
function makeSlider({ label, value, min, max, step }, moved) {
  const [, name, unit] = label.match(/^(.*?)(?: \[(.*)\])?$/);
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  // Values lie on multiples of the step, so that a joint can be set to zero.
  const onGrid = (end, rounded) => (rounded(end / step) * step).toFixed(digits);
  const id = "slider-" + makeSlider.count++;
  const input = element("input", {
    type: "range", id, step,
    min: onGrid(min, number => Math.ceil(number - 1e-6)),
    max: onGrid(max, number => Math.floor(number + 1e-6)),
  });
  const output = element("output", { htmlFor: id });
  const row = element("div", { className: "slider" }, element("label", { htmlFor: id }, name), input, output);
  const show = now => {
    const number = (Math.abs(now) < step / 2 ? 0 : now).toFixed(digits);
    input.value = now;
    output.value = (number.replace("-", "\u2212") + " " + (unit || "")).trim();
    input.setAttribute("aria-valuetext", output.value);
  };
  input.addEventListener("input", () => { show(input.valueAsNumber); moved(input.valueAsNumber); });
  show(value);
  return { row, input, show, long: name.length > 6 };
}
makeSlider.count = 0;

// Many sliders share one Tab stop: up and down choose the slider, left and right move it.
function shareTabStop(group, inputs) {
  const keep = chosen => { for (const input of inputs) input.tabIndex = input === chosen ? 0 : -1; };
  keep(inputs[0]);
  group.addEventListener("focusin", event => keep(event.target));
  group.addEventListener("keydown", event => {
    const way = { ArrowUp: -1, ArrowDown: 1 }[event.key];
    if (!way) return;
    event.preventDefault();
    inputs[(inputs.indexOf(event.target) + way + inputs.length) % inputs.length].focus();
  });
}

// A named group of sliders, which has so many Tab stops at most.
function makeGroup(name, sliders, mostTabStops) {
  const group = element("div"), inputs = sliders.map(slider => slider.input);
  group.setAttribute("role", "group");
  group.setAttribute("aria-label", name);
  if (inputs.length > mostTabStops) {
    const keys = element("p", { className: "keys", id: "keys" }, "Keys: up and down choose, left and right move.");
    group.setAttribute("aria-describedby", keys.id);
    group.append(keys);
    shareTabStop(group, inputs);
  }
  group.classList.toggle("long", sliders.some(slider => slider.long));
  group.append(...sliders.map(slider => slider.row));
  return group;
}
