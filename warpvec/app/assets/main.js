/* Starts the desk on the viewer's page. */

import { find } from "viewer/dom.js";
import { started } from "viewer/main.js";
import { Desk } from "app/desk.js";
import { showSide } from "app/parts.js";

function start(view) {
  document.querySelector("header").after(find("lost"), find("sides"), find("desk"));
  find("stage").append(find("empty"), find("proposal"));
  showSide("make");
  const desk = new Desk(view);
  window.desk = {
    fitAgain: (text, locked) => desk.fitAgain(text, locked),
    save: (text) => desk.save(text),
    reshape: (to, texts) => desk.server.reshape(to, texts),
  };
  document.body.dataset.desk = "ready";
}

started.then(start);
