// Drives Visual Studio Code in a browser, and prints what it shows. Started by vscode-check.sh.
const { chromium } = require("playwright-core");

const [browser, url, shots] = process.argv.slice(2);
const pause = (time) => new Promise((done) => setTimeout(done, time));
const FLAGS = ["--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking", "--disable-sync"];

// The editor is there as soon as the server has started.
async function open(page) {
  for (let tries = 0; ; tries += 1) {
    const problem = await page.goto(url).then(() => null, (error) => error);
    if (!problem) break;
    if (tries === 60) throw problem;
    await pause(1000);
  }
  await page.waitForSelector(".monaco-workbench", { timeout: 120000 });
  const tab = page.locator(".tab", { hasText: "lib.rs" });
  for (let tries = 0; tries < 20 && !(await tab.isVisible()); tries += 1) {
    await pause(3000);
    await page.keyboard.press("Escape");
    await page.keyboard.press("Control+p");
    await page.keyboard.type("lib.rs", { delay: 50 });
    await pause(1500);
    await page.keyboard.press("Enter");
    await pause(1000);
  }
}

async function drive(page, shot) {
  const texts = (selector) => page.$$eval(selector, (all) => all.map((it) => it.getAttribute("aria-label") || it.textContent));
  const say = (title, lines) => console.log([`${title}:`, ...lines].join("\n  "));
  await open(page);

  const finding = page.locator(".squiggly-error").first();
  await finding.waitFor({ timeout: 120000 });
  await page.keyboard.press("Control+Shift+m");
  await page.waitForSelector(".markers-panel .monaco-list-row");
  await pause(1000);
  say("problems", await texts(".markers-panel .monaco-list-row"));
  await shot("1-problems");
  await page.keyboard.press("Control+Shift+m");

  const box = await finding.boundingBox();
  await page.mouse.move(box.x + box.width - 3, box.y + 4);
  await page.waitForSelector(".monaco-hover-content .hover-row");
  await pause(1000);
  say("hover", await page.$$eval(".monaco-hover-content .hover-row", (rows) => rows.map((row) => row.innerText.slice(0, 200))));
  await shot("2-hover");
  await page.mouse.move(5, 5);

  await page.locator(".view-line", { hasText: "and once more" }).click();
  await page.keyboard.press("Control+.");
  const actions = page.locator(".action-widget .monaco-list-row.action");
  await actions.first().waitFor();
  say("quick fixes", await actions.allTextContents());
  await shot("3-quick-fixes");
  await actions.filter({ hasText: "remove this update" }).click();
  await finding.waitFor({ state: "detached", timeout: 60000 });
  const hint = page.locator(".view-line", { hasText: "proved:" });
  await hint.waitFor({ timeout: 60000 });
  say("behind the loop, after the fix", await hint.allTextContents());
  await shot("4-fixed");
}

async function main() {
  const session = await chromium.launch({ executablePath: browser, args: FLAGS });
  const page = await session.newPage({ viewport: { width: 1400, height: 900 } });
  const shot = (name) => page.screenshot({ path: `${shots}/${name}.png` });
  try {
    await drive(page, shot);
  } catch (error) {
    console.error(`not seen: ${error.message}`);
    process.exitCode = 1;
    await shot("failed");
  }
  await session.close();
}

main();
