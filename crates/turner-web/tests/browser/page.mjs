// The checks of the page: pairs of a name and an async function of a page of its own and the address of the static folder,
// which throws where the page is wrong; and the options of its host. `run.mjs` runs them.

import * as access from "./access.mjs";
import * as files from "./files.mjs";
import * as links from "./links.mjs";
import * as scene from "./scene.mjs";

export const checks = [scene, files, links, access]
  .flatMap(part => Object.entries(part))
  .map(([name, check]) => [name.replaceAll("_", " "), check, check.options]);
