/* Starts the page from the data in the file. */

import { App } from "viewer/app.js";
import { find } from "viewer/dom.js";
import { connectKeys } from "viewer/keys.js";
import { Panel } from "viewer/panel.js";
import { Stage } from "viewer/stage.js";
import { Pointer } from "viewer/tools.js";

async function start() {
  const data = JSON.parse(find("data").textContent);
  const app = new App();
  await app.live.open(data);
  app.panel = new Panel(app);
  app.stage = new Stage(app, find("art"), find("surface"));
  app.pointer = new Pointer(app, find("surface"));
  connectKeys(app);
  app.panel.request();
  window.warpvecView = app.live;
  document.body.dataset.ready = "yes";
  return app.live;
}

/** Resolves to the page as `live.js` offers it, when the page has started. */
export const started = start();

started.catch((error) => {
  find("message").textContent = `This page could not start: ${error.message}`;
  throw error;
});
