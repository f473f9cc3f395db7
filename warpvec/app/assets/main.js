/* Starts the desk on the viewer's page. */

import { find } from "viewer/dom.js";
import { started } from "viewer/main.js";
import { Desk } from "app/desk.js";
import { Memory } from "app/memory.js";
import { showSide } from "app/parts.js";
import { pageIdentifier } from "app/server.js";

async function start(view) {
  document.querySelector("header").after(find("lost"), find("sides"), find("desk"));
  find("stage").append(find("empty"), find("proposal"));
  showSide("make");
  const identity = await pageIdentifier();
  const desk = new Desk(view, identity.page, await Memory.open(identity));
  window.desk = {
    fitAgain: (text, locked) => desk.fitAgain(text, locked),
    save: (text) => desk.save(text),
    reshape: (to, texts) => desk.server.reshape(to, texts),
    undo: () => desk.removals.undo(),
    canUndo: () => desk.removals.canUndo,
    isKept: () => desk.memory.isWritten,
  };
  document.body.dataset.desk = "ready";
}

started.then(start);
