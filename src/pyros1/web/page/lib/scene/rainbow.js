// Colour maps.

// Write the red, green and blue (0 to 1) of a position from 0 (violet) to 1 (red) in a rainbow, like rviz for clouds.
export function rainbow(place, out, at) {
  const turn = (1 - Math.min(1, Math.max(0, place))) * 5;
  const index = Math.floor(turn);
  const part = turn - index;
  const up = part;
  const down = 1 - part;
  const [red, green, blue] = [
    [1, up, 0], [down, 1, 0], [0, 1, up], [0, down, 1], [up, 0, 1], [1, 0, down],
  ][Math.min(5, index)];
  out[at] = red;
  out[at + 1] = green;
  out[at + 2] = blue;
}
