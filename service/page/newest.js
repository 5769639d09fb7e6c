/** One request at a time, and after it only the newest of those that came meanwhile. */

/**
 * Returns run(task): a slider that moves faster than the service answers neither floods it nor shows old answers.
 * Meanwhile the `holder`, if there is one, says that it is busy.
 */
export function createNewest(fail, holder = null) {
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
      await next().catch(fail);
    }
    busy = false;
    holder?.removeAttribute("aria-busy");
  };
}
