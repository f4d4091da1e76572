// The panels. Each is a module in panels/ whose default export is:
//
//   {
//     title: "Plot",                  // the title of its tab
//     description: "numbers over time",
//     order: 30,                      // the position of its tab: tabs are sorted by it, from left to right
//     rare: true,                     // its tab appears only after the panel has been shown
//     layout: {...},                  // initial layout of its tab; without it, just the panel
//     mount(place) -> {unmount()}     // show the panel; place is:
//   }
//   place.body       the element to fill
//   place.tools      the element for buttons in the panel's head
//   place.robot      calls and streams, see robot.js
//   place.settings   an object, saved by the panel, or set by a link or another panel
//   place.save(s)    save settings
//   place.restart(s)                show this panel again, with these settings
//   place.open(name, settings)      show another panel beside this one
//   place.problem(text)             display what is wrong; "" for nothing
//
// To add a panel, add a file: the server finds it.

export async function panelList() {
  const response = await fetch("panels.json");
  const names = await response.json();
  const panels = await Promise.all(names.map(async (name) => {
    try {
      const module = await import(`../panels/${name}.js`);
      return { name, ...module.default, mount: module.default.mount };
    } catch (error) { // one broken panel, or one whose files were changed while the server runs, must not affect the others
      console.error(`the panel ${name} cannot be loaded: ${error.message}`);
      return null;
    }
  }));
  return panels.filter(Boolean).sort((one, other) => one.order - other.order || one.name.localeCompare(other.name));
}
