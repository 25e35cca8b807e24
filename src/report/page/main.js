// The start: data read, parts built, the page's state told by `data-state` of its root.

async function start() {
  const data = JSON.parse(byId("data").textContent);
  data.runs.forEach((run, number) => {
    run.color = data.curves[number % data.curves.length];
    run.dash = DASHES[Math.floor(number / data.curves.length) % DASHES.length];
  });
  byId("subtitle").textContent = data.runs.length === 1 ? "One run" : `${data.runs.length} runs`;
  byId("footer").textContent = `Made by ${data.program} ${data.version}. L is the unit of length of the input. ` +
    "Energy is that of the Chebyshev distance about the sites; its optimum are equal cubes, in the plane equal squares.";
  const curves = data.runs.some((run) => run.records.iteration.length > 0) ? new Curves(data, byId("curves")) : null;
  if (!curves) byId("curves").append(element("p", {}, "No run has records."));
  byId("runs").append(...data.runs.map((run) => runEntry(run, curves)));
  byId("notes").append(...data.runs.flatMap(({ name, notes }) => notes.map((note) => element("p", { class: "note" }, `${name}: ${note}.`))));
  byId("figures").append(figuresTable(data.runs));
  byId("scenes").append(...data.runs.map((run) => sceneDetails(run, false)));
  if (data.runs.some((run) => run.cells)) {
    byId("cells-section").hidden = false;
    const viewer = new CellViewer(data, byId("cells"));
    await viewer.choose(Number(remembered.get("run") ?? 0));
    viewer.updateNow();
    viewer.view.drawNow();
  }
}

/// A run's entry in the list: its line, whether its curves are shown, and its outcome.
function runEntry(run, curves) {
  const { initial, final: last, sites } = run.run;
  const box = element("input", { type: "checkbox", checked: true, change: (event) => {
    run.isHidden = !event.target.checked;
    curves?.draw();
  } });
  const energy = initial && last ? `, energy ${numberText(initial.energy_percent, 5)} → ${numberText(last.energy_percent, 5)} %` : "";
  const moves = run.records.iteration.at(-1);
  const iterations = moves === undefined ? "" : `, ${countText(moves)} iterations`;
  return element("li", {}, element("label", {}, box, swatch(run), element("b", {}, run.name),
    element("span", {}, `${countText(sites)} sites${iterations}${energy}`)));
}

// Another address with what it remembers, typed or followed in the same window.
addEventListener("hashchange", () => location.reload());

start().then(() => {
  document.documentElement.dataset.state = "ready";
}).catch((error) => {
  document.documentElement.dataset.state = "failed";
  byId("notes").append(element("p", { class: "note" }, `This page cannot be shown: ${error.message}`));
  console.error(error);
});
