// The page view.html: a model of the reader's in <turner-view>. `?src=model.glb` names one beside the page.
import "./turner-view.js";

const byId = id => document.getElementById(id);
const [view, state] = [byId("view"), byId("state")];
let name = "picture";
let url = "";

function open(file) {
  URL.revokeObjectURL(url);
  name = file.name.replace(/\.[^.]*$/, "");
  url = URL.createObjectURL(file);
  // The end of the address is the name of the file, whose extension tells the format.
  view.src = `${url}#/${encodeURIComponent(file.name)}`;
}

byId("file").addEventListener("change", event => event.target.files[0] && open(event.target.files[0]));
document.addEventListener("dragover", event => event.preventDefault());
document.addEventListener("drop", event => {
  event.preventDefault();
  if (event.dataTransfer.files[0]) open(event.dataTransfer.files[0]);
});
byId("exposure").addEventListener("input", event => view.setAttribute("exposure", event.target.value));
byId("save").addEventListener("click", async () => {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(await view.toBlob({ mimeType: "image/png" }));
  link.download = `${name}.png`;
  link.click();
  URL.revokeObjectURL(link.href);
});
view.addEventListener("progress", ({ detail }) => { state.value = `${Math.round(100 * detail.totalProgress)} %`; });
view.addEventListener("settled", () => { state.value = "Done"; });
view.addEventListener("error", ({ detail }) => { state.value = detail.message; });

const src = new URLSearchParams(location.search).get("src");
if (src && new URL(src, location.href).origin === location.origin) view.src = src;
