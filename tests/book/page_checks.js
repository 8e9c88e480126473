// What the tests ask of a page; added to every page and frame that they open.
"use strict";
window.checks = {
  async untypesetFormulas() {
    const formulas = [...document.querySelectorAll(".math")];
    if (!formulas.length) return [];
    if (!window.MathJax?.startup?.promise) return ["MathJax did not start"];
    await MathJax.startup.promise;
    return formulas
      .filter(f => !f.querySelector("mjx-container") || f.querySelector("mjx-merror, [data-mjx-error]"))
      .map(f => "formula is not typeset: " + f.textContent.trim().slice(0, 120));
  },

  // What reaches past the window's right edge without a frame of its own to scroll in.
  wideElements() {
    const width = document.documentElement.clientWidth, page = document.documentElement.scrollWidth;
    const scrolls = element => ["auto", "scroll"].includes(getComputedStyle(element).overflowX);
    const inFrame = element => {
      const parent = element.parentElement;
      return parent !== document.body && (scrolls(parent) || inFrame(parent));
    };
    const wide = [...document.querySelectorAll("article *")].filter(element => {
      const box = element.getBoundingClientRect();
      return box.width > 1 && box.right > width + 1 && !element.closest("mjx-assistive-mml") && !inFrame(element);
    });
    const described = wide.slice(0, 5).map(element =>
      `<${element.tagName.toLowerCase()} class="${element.getAttribute("class") || ""}"> ends at ` +
      `${Math.round(element.getBoundingClientRect().right)} px of ${width}: ${element.textContent.trim().slice(0, 60)}`);
    return page > width ? [`the page is ${page} px wide in a window of ${width} px`, ...described] : described;
  },

  // Whether book.css has colours for a verdict, and the contrast of its text with what is behind it.
  verdict(cssClass) {
    const channel = value => value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
    const luminance = color => {
      const [r, g, b] = color.match(/[\d.]+/g).slice(0, 3).map(value => channel(value / 255));
      return 0.2126 * r + 0.7152 * g + 0.0722 * b;
    };
    const ground = element => {
      const color = element ? getComputedStyle(element).backgroundColor : "rgb(255, 255, 255)";
      return /, 0\)$/.test(color) ? ground(element.parentElement) : color;
    };
    const sample = document.createElement("span");
    sample.className = `verdict ${cssClass}`;
    document.querySelector("article").append(sample);
    const style = getComputedStyle(sample);
    const [dark, bright] = [style.color, ground(sample)].map(luminance).sort((a, b) => a - b);
    return { styled: style.getPropertyValue("--verdict-text") !== "", contrast: (bright + 0.05) / (dark + 0.05) };
  },

  // The last words of the article, and whether they belong to a provenance footer.
  lastWords() {
    const texts = document.createTreeWalker(document.querySelector("article"), NodeFilter.SHOW_TEXT);
    let last = null;
    while (texts.nextNode()) if (texts.currentNode.textContent.trim()) last = texts.currentNode;
    return { text: last.textContent.trim(), inProvenance: last.parentElement.closest(".provenance") !== null };
  },

  // Opens all that is folded.
  unfold() {
    document.querySelectorAll("details").forEach(fold => { fold.open = true; });
  },

  // Length in screens, where the first picture and the advice begin [px], and how much code is shown.
  reading() {
    const article = document.querySelector("article.bd-article"), place = element =>
      element ? Math.round(element.getBoundingClientRect().top + scrollY) : Infinity;
    const pictures = [...article.querySelectorAll(".cell_output img, iframe")].map(place);
    const advice = [...article.querySelectorAll("h2")].find(head => head.textContent.startsWith("What it means"));
    const code = [...article.querySelectorAll(".cell_input pre")].filter(pre => pre.checkVisibility());
    return {
      screens: article.getBoundingClientRect().height / innerHeight,
      picture: Math.min(Infinity, ...pictures),
      advice: place(advice),
      lines: code.reduce((sum, pre) => sum + pre.textContent.trim().split("\n").length, 0),
    };
  },

  // Tables of numbers none of whose cells right of the first column begins on the screen.
  tablesWithoutResults() {
    return [...document.querySelectorAll("table.numbers")].filter(table => table.checkVisibility()).filter(table => {
      const row = [...table.querySelectorAll("tbody tr:not(.group)")][0];
      const results = [...row.children].slice(1).map(cell => cell.getBoundingClientRect());
      return results.length && !results.some(box => box.right <= innerWidth);
    }).map(table => table.textContent.trim().slice(0, 60));
  },

  // Pictures, scenes and tables of numbers that no numbered caption belongs to.
  withoutCaption() {
    return [...document.querySelectorAll("article .cell_output :is(img, iframe, table.numbers)")]
      .filter(shown => !shown.closest("figure:has(.caption-number)") && !shown.closest("figure figure"))
      .map(shown => (shown.title || shown.alt || shown.textContent).trim().slice(0, 60));
  },

  // In the frame of a scene. Drawn and read in one task, because the browser clears the picture afterwards.
  picture() {
    const viewer = window.viewer, gl = viewer.renderer.getContext();
    viewer.renderer.render(viewer.scene, viewer.camera);
    const pixels = new Uint8Array(gl.drawingBufferWidth * gl.drawingBufferHeight * 4);
    gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    const colors = new Set();
    let digest = 0;
    for (let i = 0; i < pixels.length; i += 4) {
      const color = pixels[i] << 16 | pixels[i + 1] << 8 | pixels[i + 2];
      colors.add(color);
      digest = (Math.imul(digest, 31) + color) | 0;
    }
    return { colors: colors.size, digest };
  },

  hasAnimation: () => window.viewer.animator.actions.length > 0,
  hasSliders: () => document.querySelector("#controls [role=group] input") !== null,
  // Where the camera is, as numbers that change when the reader turns the scene.
  camera: () => window.viewer.camera.position.toArray(),
  // Colour of the picture at a point of the world, in its three channels.
  colorAt(x, y, z) {
    const viewer = window.viewer, gl = viewer.renderer.getContext();
    viewer.renderer.render(viewer.scene, viewer.camera);
    const at = new MeshCat.THREE.Vector3(x, z, -y).project(viewer.camera), pixel = new Uint8Array(4);
    const column = (at.x + 1) / 2 * gl.drawingBufferWidth, row = (at.y + 1) / 2 * gl.drawingBufferHeight;
    gl.readPixels(Math.floor(column), Math.floor(row), 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    return [...pixel.slice(0, 3)];
  },
};
