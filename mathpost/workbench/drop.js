// The zone of drop.py: files and folders dropped on it, or chosen with its buttons. They go to Python in pieces, and
// the next one is sent when the last was answered.

const PIECE = 2 ** 20; // bytes; of a message of ten times as much the connection would end
const PATIENCE = 10_000; // ms
const SILENT = "Python does not answer: it is busy, or the connection is cut. Sending goes on when it answers.";

const mega = bytes => (bytes < 2 ** 20 ? `${Math.ceil(bytes / 1024)} kB` : `${(bytes / 2 ** 20).toFixed(1)} MB`);
const files = count => (count == 1 ? "1 file" : `${count} files`);

function made(kind, properties, ...inside) {
  const element = Object.assign(document.createElement(kind), properties);
  element.append(...inside);
  return element;
}

/** The dropped files, those in folders as well, as [name, file]; at most one more than `most`. */
async function inside(entries, most) {
  const found = [], rest = [...entries];
  while (rest.length && found.length <= most) {
    const entry = rest.shift();
    if (entry.isFile) {
      found.push([entry.fullPath.slice(1), await new Promise((done, fail) => entry.file(done, fail))]);
      continue;
    }
    const reader = entry.createReader();
    for (let some = [null]; some.length; rest.push(...some)) // it gives a hundred at a time
      some = await new Promise((done, fail) => reader.readEntries(done, fail));
  }
  return found;
}

function render({ model, el }) {
  const [label, several] = [model.get("label"), model.get("several")];
  const choose = made("button", {
    type: "button", className: "mathpost-drop-choose",
    textContent: several ? "Drop files or a folder, or choose files" : "Drop a file, or choose one",
  });
  const folder = made("button", { type: "button", textContent: "Choose a folder", hidden: !several });
  const picker = made("input", { type: "file", hidden: true, tabIndex: -1 });
  const bar = made("progress", { hidden: true });
  const stop = made("button", { type: "button", textContent: "Stop", hidden: true });
  const clear = made("button", { type: "button", textContent: "Remove all", hidden: true });
  const told = made("div", { className: "mathpost-drop-told" });
  const list = made("ul", {});
  const zone = made("div", { className: `mathpost-drop ${several ? "several" : ""}` }, choose, folder, picker, clear, bar, stop, told, list);
  zone.setAttribute("role", "group");
  zone.setAttribute("aria-label", `${label}: files`);
  for (const button of [choose, folder, clear, stop, bar])
    button.setAttribute("aria-label", `${button.textContent || "sent"}: ${label}`);
  choose.title = folder.title = model.get("bound");
  told.setAttribute("role", "status");
  el.append(zone);

  function say(text, isWrong = false) {
    told.textContent = text;
    told.classList.toggle("wrong", isWrong);
  }

  const waiting = new Map();
  const heard = answer => waiting.get(answer.id)?.(answer);
  model.on("msg:custom", heard);

  /** Python's answer; a message without one is sent again, as every message may come twice. */
  function ask(content, piece) {
    const id = `${Math.random()}`;
    const post = () => model.send({ ...content, id }, undefined, piece && [piece]);
    return new Promise(done => {
      const again = setInterval(() => (say(SILENT, true), post()), PATIENCE);
      waiting.set(id, answer => {
        clearInterval(again);
        waiting.delete(id);
        if (told.textContent == SILENT) say("");
        done(answer);
      });
      waiting.get(id).again = again;
      post();
    });
  }

  let isStopped = false;
  async function send(offered) {
    const { names, refused } = await ask({ offer: offered.map(([name, file]) => [name, file.size]) });
    if (refused) throw Error(refused);
    const coming = names.map((name, n) => [name, offered[n][1]]).filter(([name]) => name);
    const replaced = coming.map(([name]) => name).filter(name => model.get("held").some(([held]) => held == name));
    isStopped = stop.hidden = bar.hidden = false;
    bar.max = coming.reduce((sum, [, file]) => sum + file.size, 0) || 1;
    let sent = (bar.value = 0);
    for (const [n, [name, file]] of coming.entries()) {
      say(`${name}, ${n + 1} of ${files(coming.length)}, ${mega(bar.max)} together`);
      for (let have = 0; ; ) {
        const piece = await file.slice(have, have + PIECE).arrayBuffer();
        if (isStopped) throw Error(`Stopped: ${n} of ${files(coming.length)} came.`);
        const answer = await ask({ name, start: have }, piece);
        if (answer.refused) throw Error(answer.refused);
        sent += answer.have - have;
        have = answer.have;
        bar.value = sent;
        if (have >= file.size) break;
      }
    }
    say(`${files(coming.length)} came, ${mega(sent)}.` + (replaced.length ? ` Replaced: ${replaced.join(", ")}.` : ""));
  }

  let last = Promise.resolve();
  function take(found) {
    last = last
      .then(async () => send(await found))
      .catch(error => (say(error.message, true), ask({ offer: [] }))) // nothing more is expected
      .finally(() => (stop.hidden = bar.hidden = true));
  }

  function pick(isFolder) {
    Object.assign(picker, { webkitdirectory: isFolder, multiple: several, value: "" });
    picker.click();
  }
  choose.onclick = () => pick(false);
  folder.onclick = () => pick(true);
  picker.onchange = () => take([...picker.files].map(file => [file.webkitRelativePath || file.name, file]));
  clear.onclick = async () => {
    await ask({ remove: model.get("held").map(([name]) => name) });
    choose.focus();
  };
  stop.onclick = () => {
    isStopped = true;
    choose.focus();
  };
  zone.ondragover = event => {
    event.preventDefault();
    event.stopPropagation();
    zone.classList.add("over");
  };
  zone.ondragleave = () => zone.classList.remove("over");
  zone.ondrop = event => {
    zone.ondragover(event);
    zone.ondragleave();
    const entries = [...event.dataTransfer.items].map(item => item.webkitGetAsEntry()).filter(Boolean);
    if (entries.length) take(inside(entries, model.get("most")));
  };

  function show() {
    const row = ([name, size], n) => {
      const remove = made("button", { type: "button", textContent: "×", title: "remove" });
      remove.setAttribute("aria-label", `remove ${name}`);
      remove.onclick = async () => {
        await ask({ remove: [name] });
        (list.querySelectorAll("button")[Math.min(n, list.children.length - 1)] ?? choose).focus();
      };
      return made("li", {}, made("span", { textContent: name, title: name }), mega(size), remove);
    };
    const held = model.get("held");
    list.replaceChildren(...held.map(row));
    clear.hidden = held.length < 2;
  }
  model.on("change:held", show);
  show();

  return () => {
    isStopped = true;
    waiting.forEach(answer => clearInterval(answer.again));
    model.off("msg:custom", heard);
    model.off("change:held", show);
  };
}

export default { render };
