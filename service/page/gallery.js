/** The gallery: pictures of samples from consecutive seeds. */

import { samplePicture } from "./api.js";
import { element } from "./words.js";

const COUNT = 8;
const LAST_SEED = 2 ** 32 - 1;

/**
 * Make a list a gallery. Returns fill(category, seed, temperature, side), which shows the samples, seen at an azimuth of
 * `side` degrees, and mark(seed), which marks one, or none for null; choose(seed) is called for the one that is pressed.
 */
export function createGallery(list, choose) {
  const tiles = Array.from({ length: COUNT }, createTile);
  list.append(...tiles.map((tile) => element("li", {}, tile)));
  let seeds = [];

  function mark(seed) {
    tiles.forEach((tile, index) => tile.setAttribute("aria-pressed", `${seeds[index] === seed}`));
  }

  function fill(category, first, temperature, side) {
    seeds = tiles.map((_, index) => (first + index) % (LAST_SEED + 1));
    tiles.forEach((tile, index) => {
      const [picture, label] = tile.children;
      picture.src = samplePicture(category, seeds[index], temperature, side);
      label.textContent = `${seeds[index]}`;
      tile.setAttribute("aria-label", `Sample ${seeds[index]}`);
      tile.onclick = () => choose(seeds[index]);
    });
  }

  return { fill, mark };
}

function createTile() {
  const picture = element("img", { alt: "", width: 256, height: 192 });
  return element("button", { type: "button", class: "tile", "aria-pressed": "false" }, picture, element("span", {}));
}
