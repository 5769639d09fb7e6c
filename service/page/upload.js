/** Pictures from the visitor: chosen, dropped anywhere on the page, or pasted. */

/** Call receive(files) with the pictures that come in, several at a time where several are given. */
export function receivePictures(input, target, receive) {
  const take = (files) => {
    // What is no picture, the service says itself.
    if (files.length > 0) receive([...files]);
  };
  input.addEventListener("change", () => {
    take(input.files);
    // The same file can be chosen again.
    input.value = "";
  });
  // A drop beside the target would make the browser leave the page.
  document.addEventListener("dragover", (event) => {
    event.preventDefault();
    target.classList.add("wanted");
  });
  document.addEventListener("dragleave", (event) => {
    if (event.relatedTarget === null) target.classList.remove("wanted");
  });
  document.addEventListener("drop", (event) => {
    event.preventDefault();
    target.classList.remove("wanted");
    take(event.dataTransfer.files);
  });
  document.addEventListener("paste", (event) => take(event.clipboardData.files));
}
