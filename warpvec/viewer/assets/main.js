/* Starts the page from the data in the file. */

async function main() {
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
}

main().catch((error) => {
  find("message").textContent = `This page could not start: ${error.message}`;
  throw error;
});
