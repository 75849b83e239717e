// Begins with the page's script, once the first picture, which is part of the page (`picture.rs`), is
// on the screen: while the script makes a context of WebGL, nothing is drawn. Where there is no
// such picture, or it is out of sight, that must not take long. Not every browser tells when a
// picture is on the screen, but all tell when frames begin.
{
  const begin = () => import("./view.js");
  if (!document.querySelector(".first")) {
    begin();
  } else {
    setTimeout(begin, 500);
    if (PerformanceObserver.supportedEntryTypes.includes("element")) {
      new PerformanceObserver(begin).observe({ type: "element", buffered: true });
    } else {
      requestAnimationFrame(() => requestAnimationFrame(begin));
    }
  }
}
