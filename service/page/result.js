/** The result: what was found in pictures, told in words, bars and the dial. */

import { drawDial } from "./dial.js";
import { createStage } from "./stage.js";
import {
  bearing,
  capital,
  colour,
  colourName,
  counted,
  decimal,
  degrees,
  element,
  listed,
  one,
  percent,
  probability,
  time,
} from "./words.js";

const CLASSES = 5;
const STAGES = {
  picture: "Reading the picture",
  encoder: "Pose and shape code",
  decoder: "Mesh",
  render: "Drawing it again",
  refine: "Refining",
  glb: "Writing the GLB",
};

/**
 * Make the section a result. Returns show({ report, glb, pictures, overlay, elapsed }), which fills and opens it;
 * vary({ report, glb }, words) is called where the visitor wants to change the shape that was found.
 */
export function createResult(section, vary) {
  const find = (id) => section.querySelector(`#${id}`);
  const stage = createStage(find("turntable"));
  const bare = find("bare");
  bare.addEventListener("change", () => compare(find, bare.checked));
  let addresses = [];

  return function show({ report, glb, pictures, overlay, elapsed }) {
    section.hidden = false;
    addresses.forEach((address) => URL.revokeObjectURL(address));
    addresses = [overlay, pictures[0], new Blob([glb], { type: "model/gltf-binary" })].map((blob) =>
      URL.createObjectURL(blob),
    );
    [find("overlay").src, find("original").src, find("download").href] = addresses;
    find("download").download = `${report.category}.glb`;
    const facing = `its front points ${bearing(report.azimuth_degrees)}`;
    find("overlay").alt = `The mesh of ${one(report.category)}, drawn over the picture; ${facing}`;
    compare(find, bare.checked);
    stage({ report, glb }, `The mesh of ${one(report.category)}; ${facing}`);
    tellPose(find, report);
    tellLight(find, report);
    tellObject(find, report);
    find("vary").onclick = () => {
      vary({ report, glb }, "The shape from the picture");
      document.querySelector("#shape input").focus();
    };
    tellTime(find, report.timings_ms, elapsed);
  };
}

function compare(find, bare) {
  find("overlay").hidden = bare;
  find("original").hidden = !bare;
}

function tellPose(find, report) {
  const { azimuth_degrees: azimuth, hypotheses, views, posterior } = report;
  find("pose-words").textContent = `The front points ${bearing(azimuth)}.${alike(posterior)}`;
  drawDial(find("dial"), find("dial-label"), report);
  find("hypotheses").replaceChildren(
    ...hypotheses.map((guess) =>
      element(
        "li",
        {},
        element("span", {}, degrees(guess.azimuth_degrees)),
        element("span", {}, probability(guess.probability)),
      ),
    ),
  );
  const several = (views?.length ?? 0) > 1;
  find("views").hidden = !several;
  if (several) {
    const turns = views.map((view) => degrees(view.azimuth_degrees));
    find("views").textContent = `The shape is that of ${views.length} pictures together, seen at ${listed(turns)}.`;
  }
}

function alike({ azimuth_symmetry: order, azimuth_bins: bins }) {
  if (order === bins.length) return " But its front cannot be told: turned otherwise it would look alike.";
  return order > 1 ? ` Turned by ${degrees(360 / order)} it would look alike.` : "";
}

function tellLight(find, { lights, ambient, posterior }) {
  const known = posterior.light === null;
  const count = capital(counted(lights.length, "light"));
  find("light-words").textContent = known
    ? `${count}, where the model knows them to be.`
    : `${count}, turned as a whole: ${probability(posterior.light.confidence)} sure.`;
  find("lights").replaceChildren(
    ...lights.map((light) => {
      const swatch = element("span", { class: "swatch" });
      swatch.style.background = colour(light.colour);
      const place = `${bearing(light.azimuth_degrees)}, ${degrees(light.elevation_degrees)} up`;
      return element("li", {}, swatch, element("span", {}, `${colourName(light.colour)}, ${place}`));
    }),
  );
  find("ambient").textContent = Math.max(...ambient) > 0 ? `And ${percent(Math.max(...ambient))} from everywhere.` : "";
}

function tellObject(find, { category, category_probabilities: probabilities, out_of_class_score: score }) {
  const guessed = Object.entries(probabilities ?? {}).sort(([, first], [, second]) => second - first);
  find("class-words").textContent =
    guessed.length > 1
      ? `${capital(one(category))}, ${probability(guessed[0][1])} sure.`
      : `Taken for ${one(category)}.`;
  const others = `pictures of ${one(category)} that it was not trained on`;
  find("doubt").hidden = !(score > 1);
  find("doubt").textContent =
    `Doubt this. The model explains the picture worse than it explains nineteen in twenty ${others} ` +
    `(score ${decimal(score ?? 0)}; 1 is the worst of twenty).`;
  find("fit").textContent =
    score === null || score > 1 ? "" : `Explained as well as ${others} (score ${decimal(score)}).`;
  find("classes").hidden = guessed.length < 2;
  find("classes").replaceChildren(
    ...guessed.slice(0, CLASSES).map(([name, share]) => {
      const bar = element("li", {}, element("span", {}, name), element("span", {}, probability(share)));
      bar.style.setProperty("--share", `${100 * share}%`);
      return bar;
    }),
  );
}

function tellTime(find, timings, elapsed) {
  const sum = Object.values(timings).reduce((total, value) => total + value, 0);
  find("time-words").textContent = `${time(sum)} in the service, ${time(elapsed)} until it was here.`;
  find("timings").replaceChildren(
    ...Object.entries(timings).flatMap(([name, value]) => [
      element("dt", {}, STAGES[name] ?? name),
      element("dd", {}, time(value)),
    ]),
  );
}
