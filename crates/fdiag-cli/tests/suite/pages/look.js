// What is wrong with the page in the frame, for browser.rs.
function look(frame) {
  const view = frame.contentWindow, page = view.document, root = page.documentElement;
  const found = { width: view.innerWidth, dark: view.matchMedia("(prefers-color-scheme: dark)").matches,
    pictures: 0, words: page.body.innerText.length, clipped: [], empty: [], faint: [], nameless: [], dead: [] };
  const name = e => e.tagName + "." + (e.getAttribute("class") || "") + " " + (e.textContent || "").trim().slice(0, 60);
  const scrolls = e => {
    for (; e && e !== page.body; e = e.parentElement)
      if (/auto|scroll/.test(view.getComputedStyle(e).overflowX)) return true;
    return false;
  };
  // What is folded away has to be in order as well.
  for (const details of page.querySelectorAll("details")) details.open = true;
  if (root.clientWidth < root.scrollWidth) found.clipped.push("the page is " + root.scrollWidth + " wide");
  for (const e of page.body.querySelectorAll("*")) {
    const box = e.getBoundingClientRect();
    if (box.width && (root.clientWidth + 0.5 < box.right || box.left < -0.5) && !scrolls(e)) found.clipped.push(name(e));
  }
  for (const svg of page.querySelectorAll("svg")) {
    found.pictures += 1;
    if (svg.getAttribute("role") !== "img" || !svg.getAttribute("aria-label")) found.nameless.push(name(svg));
    const frame = svg.getBoundingClientRect();
    const drawn = [...svg.querySelectorAll("path,polyline,polygon,line,circle,rect")].filter(e => {
      const box = e.getBoundingClientRect();
      return 0 < box.width + box.height && view.getComputedStyle(e).display !== "none";
    });
    // A ground and a frame alone show nothing.
    if (frame.width < 40 || frame.height < 20 || drawn.length < 2) found.empty.push(name(svg));
    for (const text of svg.querySelectorAll("text")) {
      const box = text.getBoundingClientRect();
      if (box.left < frame.left - 1 || frame.right + 1 < box.right || box.top < frame.top - 1 || frame.bottom + 1 < box.bottom)
        found.clipped.push("in a picture: " + name(text));
    }
  }
  // Words that cannot be told from what is behind them: a contrast below 3, as WCAG 2 counts it.
  const numbers = color => (color.match(/[\d.]+/g) || []).map(Number);
  const light = ([r, g, b]) => [r, g, b].map(c => c / 255).map(c => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4)
    .reduce((sum, c, i) => sum + c * [0.2126, 0.7152, 0.0722][i], 0);
  const behind = e => {
    for (; e; e = e.parentElement) {
      const ground = numbers(view.getComputedStyle(e).backgroundColor);
      if (ground.length === 3 || ground[3] === 1) return ground;
    }
    return found.dark ? [18, 18, 18] : [255, 255, 255];
  };
  const words = page.createTreeWalker(page.body, NodeFilter.SHOW_TEXT);
  while (words.nextNode()) {
    const e = words.currentNode.parentElement;
    if (!words.currentNode.data.trim() || /SCRIPT|STYLE/.test(e.tagName) || !e.getClientRects().length) continue;
    const style = view.getComputedStyle(e), isDrawn = e.namespaceURI.endsWith("svg");
    const [a, b] = [light(numbers(isDrawn ? style.fill : style.color)), light(behind(isDrawn ? e.ownerSVGElement : e))];
    if ((Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05) < 3) found.faint.push(name(e));
  }
  // Values under the pointer and at the arrow keys, zoom by dragging, and back.
  for (const plot of page.querySelectorAll("[data-plot]")) {
    const svg = plot.querySelector("svg"), box = svg.getBoundingClientRect(), values = plot.querySelector(".values");
    const send = (kind, share) => svg.dispatchEvent(new view.PointerEvent(kind, { bubbles: true, pointerType: "mouse",
      clientX: box.left + share * box.width, clientY: box.top + box.height / 2 }));
    const says = (works, what) => { if (!works) found.dead.push(what + ": " + name(svg)); };
    send("pointermove", 0.5);
    says(values && !values.hidden && /\d/.test(values.textContent), "no values");
    send("pointerleave", 0.5);
    says(values && values.hidden, "values stay");
    for (const [kind, share] of [["pointerdown", 0.2], ["pointermove", 0.5], ["pointerup", 0.9]]) send(kind, share);
    says(svg.classList.contains("zoomed") && !plot.querySelector("button").hidden, "no zoom");
    svg.dispatchEvent(new view.KeyboardEvent("keydown", { key: "ArrowRight" }));
    says(values && !values.hidden, "no values at keys");
    svg.dispatchEvent(new view.KeyboardEvent("keydown", { key: "Escape" }));
    says(!svg.classList.contains("zoomed"), "no way back");
  }
  for (const list of ["clipped", "empty", "faint", "nameless", "dead"]) found[list] = [...new Set(found[list])].slice(0, 20);
  return found;
}
