// All files of a folder that is dropped, or chosen, however deep they lie.

"use strict";
window.wheelhop = window.wheelhop || {};

wheelhop.filesOf = async (transfer, endings) => {
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry?.()).filter(Boolean);
  if (!entries.some((entry) => entry.isDirectory)) return [...transfer.files];
  const inside = async (entry) => {
    if (entry.isFile) return [await new Promise((done, failed) => entry.file(done, failed))];
    const reader = entry.createReader();
    const found = [];
    for (;;) {  // it gives a hundred at a time
      const some = await new Promise((done, failed) => reader.readEntries(done, failed));
      if (!some.length) break;
      for (const each of some) found.push(...(await inside(each)));
    }
    return found;
  };
  const every = [];
  for (const entry of entries) every.push(...(await inside(entry)));
  return wheelhop.readable(every, endings);
};

wheelhop.readable = (files, endings) =>
  files.filter((file) => endings.some((ending) => file.name.toLowerCase().endsWith(ending)));

wheelhop.chooseFolder = (endings, take) => {
  const input = document.createElement("input");
  input.type = "file";
  input.webkitdirectory = true;
  input.onchange = () => take(wheelhop.readable([...input.files], endings));
  input.click();
};
