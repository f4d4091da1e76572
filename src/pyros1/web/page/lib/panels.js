// The panels. Each is a module in panels/ with this as its default export:
//
//   {
//     title: "Plot",                  // of its tab
//     description: "numbers over time",
//     order: 30,                      // of the tabs, from left to right
//     rare: true,                     // no tab before it is first shown, by its link or in a panel's head
//     layout: {...},                  // how its tab begins; without it, the panel alone
//     mount(place) -> {unmount()}     // show it; place is:
//   }
//   place.body       the element to fill
//   place.tools      the element for buttons in the panel's head
//   place.robot      calls and streams, see robot.js
//   place.settings   what the panel saved before, or what a link or another panel says; an object
//   place.save(s)    keep settings
//   place.restart(s)                show this panel again, with these settings
//   place.open(name, settings)      show another panel beside this one
//   place.problem(text)             say what is wrong; "" for nothing
//
// A new panel is one new file; the server finds it.

export async function panelList() {
  const answer = await fetch("panels.json");
  const names = await answer.json();
  const panels = await Promise.all(names.map(async (name) => {
    try {
      const module = await import(`../panels/${name}.js`);
      return { name, ...module.default, mount: module.default.mount };
    } catch (error) { // one that is broken, or whose files have changed under a running server, takes no other with it
      console.error(`the panel ${name} cannot be loaded: ${error.message}`);
      return null;
    }
  }));
  return panels.filter(Boolean).sort((one, other) => one.order - other.order || one.name.localeCompare(other.name));
}
