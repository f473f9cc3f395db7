/* Starts the page from the data in the file. */

async function main() {
  const data = JSON.parse(find("data").textContent);
  const drawing = readDrawing(data.svg);
  const app = new App(data, drawing);
  if (data.photo) app.meter = new Meter(await loadPhoto(data.photo), drawing.box);
  if (app.meter) app.split = 50;
  app.panel = new Panel(app);
  app.stage = new Stage(app, find("art"), find("surface"));
  app.pointer = new Pointer(app, find("surface"));
  connectKeys(app);
  app.panel.request();
  document.body.dataset.ready = "yes";
}

main().catch((error) => {
  find("message").textContent = `This page could not start: ${error.message}`;
  throw error;
});
