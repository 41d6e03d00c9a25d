// The machine above the curves, of a scope that was told what it looks like: lines and discs in metres, as they are now.
//
// SVG, so that sizes of the text and colours of the theme are the style sheet's alone; only the scale is reckoned here.
"use strict";

class Picture {
  // Thinner lines would be lost on a screen, px: a wire is a fraction of a millimetre.
  static THINNEST = 2;
  // The words change so often, ms: figures that change with every picture cannot be read.
  static READABLE = 250;

  // Drawn into `svg`; what it says is written into `words`.
  constructor(svg, words) {
    this.svg = svg;
    this.words = words;
    this.coming = null;
    this.picture = null;
    this.ratio = null;
    this.due = false;
    this.old = false;
    // also called once at first, and when it is shown after having been hidden
    new ResizeObserver(() => this.draw()).observe(svg);
    setInterval(() => this.say(), Picture.READABLE);
  }

  // Another one: drawn with the next frame of the screen, of all that have come by then the last.
  show(picture) {
    this.coming = picture;
    this.ask();
  }

  ask() {
    if (this.due) return;
    this.due = true;
    requestAnimationFrame(() => {
      this.due = false;
      // whoever draws it may go on without a driver: what was seen last stands still
      if (!this.old) this.picture = this.coming;
      this.draw();
    });
  }

  draw() {
    if (!this.picture) return;
    const { shapes, half_size: [x, y] } = this.picture, ratio = `${x} / ${y}`;
    if (this.ratio !== ratio) { this.ratio = ratio; this.svg.style.aspectRatio = ratio; }
    const { clientWidth: width, clientHeight: height } = this.svg, scale = Math.min(width / x, height / y) / 2;
    const at = ([x, y]) => [width / 2 + scale * x, height / 2 - scale * y];
    shapes.forEach((shape, i) => {
      if (shape.line) {
        const [x1, y1] = at(shape.line), [x2, y2] = at(shape.line.slice(2));
        this.place(i, "line", shape.ink, { x1, y1, x2, y2, "stroke-width": Math.max(Picture.THINNEST, scale * shape.width) });
      } else {
        const [cx, cy] = at(shape.disc);
        this.place(i, "circle", shape.ink, { cx, cy, r: scale * shape.radius });
      }
    });
    while (this.svg.children.length > shapes.length) this.svg.lastChild.remove();
  }

  // The shape at this place of the drawing: the one that is there already, if it is of this kind.
  place(i, kind, ink, attributes) {
    let made = this.svg.children[i];
    if (made?.localName !== kind) {
      const old = made;
      made = document.createElementNS("http://www.w3.org/2000/svg", kind);
      if (old) old.replaceWith(made); else this.svg.append(made);
    }
    made.dataset.ink = ink;
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value.toFixed(2));
  }

  // In words, for those who see it and, as the drawing's name, for those who do not: a name that changes is not read out.
  say() {
    const said = this.picture?.says ?? "", words = said && this.old ? `last seen: ${said}` : said;
    if (this.words.textContent === words) return;
    this.words.textContent = words;
    this.svg.setAttribute("aria-label", words);
  }

  // Whether it is of the past.
  past(old) {
    if (old === this.old) return;
    this.old = old;
    this.svg.parentElement.classList.toggle("past", old);
    this.ask();
  }
}
