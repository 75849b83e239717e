// The first picture: the program draws it while the browser still reads the script of the page
// and makes its shaders, which draws the same in its place as soon as it can (see `picture.rs`).
{
  const { clientWidth, clientHeight } = document.getElementById("stage");
  const [width, height] = [clientWidth, clientHeight].map((side) => Math.floor(side * window.devicePixelRatio));
  const theme = window.matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
  const picture = document.getElementById("first");
  const start = () => import("./view.js");
  picture.onload = () => {
    picture.hidden = false;
    // The script makes a context of WebGL, and meanwhile nothing is drawn: it waits until the
    // picture is on the screen, but for no longer than this, lest it be out of sight. Not every
    // browser tells that, but all tell when frames begin.
    setTimeout(start, 500);
    if (PerformanceObserver.supportedEntryTypes.includes("element")) {
      new PerformanceObserver(start).observe({ type: "element", buffered: true });
    } else {
      requestAnimationFrame(() => requestAnimationFrame(start));
    }
  };
  // (There is no picture of a model that takes long, or has a mistake.)
  picture.onerror = start;
  picture.src = `picture/${width}/${height}/${theme}`;
}
