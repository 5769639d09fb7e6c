/** Numbers in words and with units, and the small elements that hold them. */

/** An angle, degrees: 34°, −120°. */
export function degrees(value) {
  return `${number(value)}°`;
}

/** A number with one digit after the point: −0.5. */
export function decimal(value) {
  return value.toFixed(1).replace("-", "−");
}

/** A share, 0 to 1: 81 %. */
export function percent(value) {
  return `${number(100 * value)} %`;
}

/** A probability, 0 to 1, never as impossible or certain: 81 %, under 1 %. */
export function probability(value) {
  if (value < 0.005) return "under 1 %";
  return value > 0.995 ? "over 99 %" : percent(value);
}

/** A time, given in milliseconds: 0.4 ms, 1.8 s. */
export function time(value) {
  if (value >= 1000) return `${(value / 1000).toFixed(1)} s`;
  return `${value < 10 ? value.toFixed(1) : number(value)} ms`;
}

/** Where an azimuth points, as seen by the camera: 0 towards it, 90 to the right. */
export function bearing(azimuth) {
  const turn = Math.round(azimuth - 360 * Math.round(azimuth / 360));
  if (turn === 0) return "towards the camera";
  if (Math.abs(turn) === 180) return "away from the camera";
  return `${Math.abs(turn)}° to the ${turn > 0 ? "right" : "left"}`;
}

/** How many, as a word where it is a small number: three lights. */
export function counted(count, noun) {
  const words = ["no", "one", "two", "three", "four", "five", "six"];
  return `${words[count] ?? count} ${noun}${count === 1 ? "" : "s"}`;
}

/** A noun with its article: a car, an airplane. */
export function one(noun) {
  return `${/^[aeiou]/.test(noun) ? "an" : "a"} ${noun}`;
}

/** With a capital, as a sentence begins. */
export function capital(words) {
  return `${words.charAt(0).toUpperCase()}${words.slice(1)}`;
}

/** Words in a row: a, b and c. */
export function listed(words) {
  return words.length < 2 ? words.join("") : `${words.slice(0, -1).join(", ")} and ${words.at(-1)}`;
}

/** Linear RGB as a colour of CSS; brighter than white is white. */
export function colour(linear) {
  return `color(srgb-linear ${linear.map((value) => Math.min(1, value).toFixed(4)).join(" ")})`;
}

/** The name of a linear colour. */
export function colourName([red, green, blue]) {
  const most = Math.max(red, green, blue);
  if (most === 0) return "no light";
  const key = [red, green, blue].map((value) => (value > 0.5 * most ? "1" : "0")).join("");
  return { 111: "white", 100: "red", "010": "green", "001": "blue", 110: "yellow", 101: "magenta", "011": "cyan" }[key];
}

/** An element with attributes and children; text is text. */
export function element(name, attributes, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

function number(value) {
  const rounded = Math.round(value);
  return rounded < 0 ? `−${-rounded}` : `${Math.abs(rounded)}`;
}
