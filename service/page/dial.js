/** The azimuth dial: the object from above, with the camera below, the posterior around it, and the lights outside. */

import { bearing, colour, degrees, probability } from "./words.js";

const INNER = 40;
const OUTER = 84;
const LIGHT = 108;

/** Draw a report's posterior, hypotheses and lights into an SVG element; its words go into `label`. */
export function drawDial(svg, label, { azimuth_degrees: azimuth, posterior, hypotheses, lights }) {
  const bins = posterior.azimuth_bins;
  const width = 360 / bins.length;
  svg.replaceChildren(
    ...[INNER, OUTER].map((radius) => shape("circle", { class: "ring", r: radius })),
    ...bins.map((bin) =>
      shape("path", { class: "bin", d: sector(bin.azimuth_degrees, width - 3, INNER, reach(bin.probability)) }),
    ),
    ...hypotheses.map((guess, rank) => mark(guess.azimuth_degrees, rank)).reverse(),
    arrow(azimuth),
    ...lights.map((light) => sun(light)),
    eye(),
  );
  const guesses = hypotheses.map((guess) => `${degrees(guess.azimuth_degrees)} ${probability(guess.probability)}`);
  const suns = lights.map((light) => degrees(light.azimuth_degrees));
  label.textContent =
    `Dial, from above: the front points ${bearing(azimuth)}. ` +
    `Directions: ${guesses.join(", ")}. Lights: ${suns.join(", ") || "none"}.`;
}

/** How far out a bin reaches: its area, not its length, is its probability. */
function reach(share) {
  return Math.sqrt(INNER ** 2 + share * (OUTER ** 2 - INNER ** 2));
}

function sector(azimuth, width, inner, outer) {
  const [a, b, c, d] = [
    point(azimuth - width / 2, inner),
    point(azimuth - width / 2, outer),
    point(azimuth + width / 2, outer),
    point(azimuth + width / 2, inner),
  ].map((corner) => corner.map((value) => value.toFixed(2)).join(" "));
  return `M${a}L${b}A${outer} ${outer} 0 0 0 ${c}L${d}A${inner} ${inner} 0 0 1 ${a}Z`;
}

function mark(azimuth, rank) {
  const [x, y] = point(azimuth, OUTER);
  const text = shape("text", { x, y, dy: "0.36em" });
  text.textContent = `${rank + 1}`;
  return group({ class: rank === 0 ? "mark best" : "mark" }, shape("circle", { cx: x, cy: y, r: 9 }), text);
}

/** The object: an arrow whose tip is its front. */
function arrow(azimuth) {
  const corners = [point(azimuth, 28), point(azimuth + 140, 22), point(azimuth + 180, 10), point(azimuth - 140, 22)];
  return shape("path", { class: "object", d: `M${corners.map((corner) => corner.join(" ")).join("L")}Z` });
}

function sun({ azimuth_degrees: azimuth, colour: linear }) {
  const [x, y] = point(azimuth, LIGHT);
  const [nearX, nearY] = point(azimuth, LIGHT - 18);
  return group(
    { class: "sun" },
    shape("line", { x1: x, y1: y, x2: nearX, y2: nearY }),
    shape("circle", { cx: x, cy: y, r: 7, fill: colour(linear) }),
  );
}

function eye() {
  const text = shape("text", { class: "eye", x: 0, y: 127 });
  text.textContent = "camera";
  return text;
}

/** Right and down of the middle, as seen from above: azimuth 0 points to the camera, which is below; 90 to the right. */
function point(azimuth, radius) {
  const turn = (azimuth * Math.PI) / 180;
  return [radius * Math.sin(turn), radius * Math.cos(turn)];
}

function group(attributes, ...children) {
  const made = shape("g", attributes);
  made.append(...children);
  return made;
}

function shape(name, attributes) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
}
