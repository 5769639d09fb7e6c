/** One request at a time, and after it only the newest of those that came meanwhile. */

/**
 * Returns run(task): a slider that moves faster than the service answers neither floods it nor shows old answers.
 * Meanwhile the `holder`, if there is one, says that it is busy. `succeed` is called after each task that did not fail.
 */
export function createNewest(fail, holder = null, succeed = () => {}) {
  let waiting = null;
  let busy = false;

  return async function run(task) {
    waiting = task;
    if (busy) return;
    busy = true;
    holder?.setAttribute("aria-busy", "true");
    while (waiting !== null) {
      const next = waiting;
      waiting = null;
      await next().then(succeed, fail);
    }
    busy = false;
    holder?.removeAttribute("aria-busy");
  };
}
