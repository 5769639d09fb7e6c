/** Sliders over the directions of the shape code in which a model's shapes differ most. */

import { decimal, element } from "./words.js";

const SLIDERS = 6;
const REACH = 3;

/**
 * Make an element hold sliders. Returns start(shapeCode, dimensions): sets them to a shape code's numbers at the given
 * dimensions, most active first. change(shapeCode) is called as they move.
 */
export function createSliders(holder, undo, change) {
  let begun = [];
  let code = [];
  let shown = [];

  function place(shapeCode) {
    code = [...shapeCode];
    for (const { dimension, input, output } of shown) {
      input.value = code[dimension];
      output.value = decimal(code[dimension]);
    }
    undo.disabled = code.every((value, index) => value === begun[index]);
  }

  undo.addEventListener("click", () => {
    place(begun);
    // A disabled button has no focus.
    shown[0].input.focus();
    change(code);
  });

  return function start(shapeCode, dimensions) {
    begun = shapeCode;
    shown = dimensions.slice(0, SLIDERS).map((dimension, rank) => {
      const slider = createSlider(rank + 1);
      slider.input.addEventListener("input", () => {
        place(code.with(dimension, slider.input.valueAsNumber));
        change(code);
      });
      return { dimension, ...slider };
    });
    holder.replaceChildren(...shown.map(({ field }) => field));
    place(shapeCode);
  };
}

function createSlider(rank) {
  const id = `direction-${rank}`;
  const input = element("input", { id, type: "range", min: -REACH, max: REACH, step: 0.05 });
  const output = element("output", { for: id, "aria-live": "off" });
  const words = element("span", {}, element("label", { for: id }, `Direction ${rank}`), " ", output);
  return { input, output, field: element("p", { class: "field" }, words, input) };
}
