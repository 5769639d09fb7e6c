/** The way between two samples. */

import { percent } from "./words.js";

/** Call change(fromSeed, toSeed, t) as the visitor moves along the way between two seeds, or names other seeds. */
export function createWay(from, to, way, output, change) {
  function move() {
    output.value = percent(way.valueAsNumber);
    way.setAttribute("aria-valuetext", output.value);
    if (from.reportValidity() && to.reportValidity()) change(from.valueAsNumber, to.valueAsNumber, way.valueAsNumber);
  }
  way.addEventListener("input", move);
  from.addEventListener("change", move);
  to.addEventListener("change", move);
}
