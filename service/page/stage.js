/** A stage: shows one object. At once in a picture; and on a turntable, once that is loaded and if it is installed. */

import { shapePicture } from "./api.js";
import { createNewest } from "./newest.js";
import { degrees, element } from "./words.js";

const TURNTABLE = "./turntable/model-viewer.min.js";
const MISSING =
  "The turntable is not installed on this service, or this browser has no WebGL. " +
  "The slider turns the picture, and any GLB viewer the file.";

/**
 * Make an element a stage. Returns show({ report, glb }, words), where `words` say what is to be seen. It is first seen
 * at the report's azimuth; while that stays the same, so does the side that the visitor chose.
 */
export function createStage(holder) {
  const picture = element("img", { alt: "" });
  holder.append(picture);
  const run = createNewest(standStill);
  let viewer = null;
  let slider = null;
  let latest = null;
  let begun = false;

  const seen = new IntersectionObserver(([entry]) => {
    if (begun || !entry.isIntersecting) return;
    begun = true;
    seen.disconnect();
    if (hasWebGL()) import(TURNTABLE).then(turn, standStill);
    else standStill();
  });

  function turn() {
    viewer = createViewer();
    holder.append(viewer);
    run(() => place(holder, viewer, latest));
  }

  function standStill() {
    if (slider !== null) return;
    viewer?.remove();
    holder.classList.remove("turns");
    slider = createSlider(holder.id, latest.report.azimuth_degrees);
    slider.addEventListener("input", () => showPicture(slider.valueAsNumber));
    holder.after(element("p", { class: "missing quiet" }, MISSING), slider);
    showPicture(slider.valueAsNumber);
  }

  function showPicture(side) {
    picture.src = shapePicture(latest.report, side);
    picture.alt = latest.words;
    slider?.setAttribute("aria-valuetext", degrees(side));
  }

  return function show({ report, glb }, words) {
    const side = report.azimuth_degrees;
    if (slider !== null && side !== latest.report.azimuth_degrees) slider.value = side;
    latest = { report, glb, words };
    if (slider !== null) {
      showPicture(slider.valueAsNumber);
    } else if (viewer !== null) {
      run(() => place(holder, viewer, latest));
    } else {
      showPicture(side);
      if (!begun) seen.observe(holder);
    }
  };
}

function hasWebGL() {
  return document.createElement("canvas").getContext("webgl2") !== null;
}

function createSlider(name, side) {
  const slider = element("input", {
    type: "range",
    min: -180,
    max: 180,
    step: 5,
    "aria-label": "Azimuth",
    class: "turn",
  });
  slider.id = `${name}-turn`;
  slider.value = side;
  return slider;
}

function createViewer() {
  return element("model-viewer", {
    "camera-controls": "",
    "camera-target": "0m 0m 0m",
    "disable-pan": "",
    // The picture's lights are in the file, and no other: the surroundings are dark.
    "environment-image": "turntable/dark.hdr",
    "interaction-prompt": "none",
    loading: "eager",
    "tone-mapping": "none",
    "touch-action": "pan-y",
  });
}

/** Resolves once the turntable shows the GLB. */
async function place(holder, viewer, { report, glb, words }) {
  const { camera, azimuth_degrees: side } = report;
  // The object stands still in its file, and the camera has turned the other way.
  const first = `${-side}deg ${90 - camera.elevation_degrees}deg ${camera.distance}m`;
  // With every file the camera goes back to where it was told to be.
  viewer.setAttribute("camera-orbit", viewer.dataset.side === `${side}` ? `${viewer.getCameraOrbit()}` : first);
  viewer.dataset.side = side;
  viewer.setAttribute("min-camera-orbit", `-Infinity 5deg ${0.7 * camera.distance}m`);
  viewer.setAttribute("max-camera-orbit", `Infinity 175deg ${1.5 * camera.distance}m`);
  viewer.setAttribute("field-of-view", `${camera.field_of_view_degrees}deg`);
  viewer.setAttribute("alt", words);
  const address = URL.createObjectURL(new Blob([glb], { type: "model/gltf-binary" }));
  const listening = new AbortController();
  const loaded = new Promise((resolve, reject) => {
    viewer.addEventListener("load", resolve, { signal: listening.signal });
    viewer.addEventListener("error", reject, { signal: listening.signal });
  });
  viewer.setAttribute("src", address);
  await loaded.finally(() => {
    listening.abort();
    URL.revokeObjectURL(address);
  });
  holder.classList.add("turns");
}
