// Contrast of text by WCAG 2.2, 1.4.3: computed from the styles of the page. The function runs in the page.

/** Text whose contrast is below 4.5, or below 3 where it is large: [{text, ratio}]. */
export function lowContrast() {
  const context = Object.assign(document.createElement("canvas"), { width: 1, height: 1 }).getContext("2d", { willReadFrequently: true });
  // The canvas converts every way to write a colour to [r, g, b, alpha].
  const parse = text => {
    context.clearRect(0, 0, 1, 1);
    context.fillStyle = text;
    context.fillRect(0, 0, 1, 1);
    const [r, g, b, a] = context.getImageData(0, 0, 1, 1).data;
    return [r, g, b, a / 255];
  };
  const over = (front, back) => [0, 1, 2].map(i => front[i] * front[3] + back[i] * (1 - front[3]));
  const linear = x => x / 255 <= 0.04045 ? x / 255 / 12.92 : ((x / 255 + 0.055) / 1.055) ** 2.4;
  const luminance = c => 0.2126 * linear(c[0]) + 0.7152 * linear(c[1]) + 0.0722 * linear(c[2]);

  const background = element => {
    const layers = [];
    for (let at = element; at; at = at.parentElement) {
      const color = parse(getComputedStyle(at).backgroundColor);
      if (color[3] > 0) layers.push(color);
      if (color[3] === 1) break;
    }
    const page = parse(matchMedia("(prefers-color-scheme: dark)").matches ? "#121212" : "#ffffff");
    return layers.reduceRight((back, front) => over(front, back), page);
  };
  const shown = element => {
    for (let at = element; at; at = at.parentElement) {
      const style = getComputedStyle(at);
      if (style.visibility === "hidden" || style.display === "none" || style.clipPath !== "none") return false;
    }
    return element.getClientRects().length > 0;
  };
  const dialog = document.querySelector("dialog[open]");
  const found = [];
  const walker = document.createTreeWalker(dialog || document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const text = walker.currentNode.textContent.trim();
    const element = walker.currentNode.parentElement;
    // Text of drawings lies over shapes; option lists are drawn by the system; what is disabled has no requirement.
    if (!text || element.closest("script, style, noscript, textarea, option, .legend, [disabled], [aria-disabled=true]") || !shown(element)) continue;
    const style = getComputedStyle(element);
    const isDrawing = element.closest("svg");
    const back = background(isDrawing || element);
    const ink = over(parse(isDrawing ? style.fill : style.color), back);
    const [high, low] = [luminance(ink), luminance(back)].sort((a, b) => b - a);
    const ratio = (high + 0.05) / (low + 0.05);
    const size = parseFloat(style.fontSize);
    const isLarge = size >= 24 || size >= 18.66 && Number(style.fontWeight) >= 700;
    if (ratio < (isLarge ? 3 : 4.5)) found.push({ text: text.slice(0, 40), ratio });
  }
  return found;
}
