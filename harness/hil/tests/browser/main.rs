//! Reports in a real browser: no messages, complete, legible in light and dark, on a phone and on paper, and
//! self-contained.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]
#![cfg(unix)]

mod chromium;
mod pages;

use chromium::{Browser, VIEWS, View, program};
use pages::Pages;
use serde_json::{Value, json};
use std::path::Path;

/// Events by which a browser reports problems of a page.
const COMPLAINTS: [&str; 4] = [
    "Log.entryAdded",
    "Runtime.consoleAPICalled",
    "Runtime.exceptionThrown",
    "Network.loadingFailed",
];

/// Minimum contrast of text (WCAG 2.2, level AA).
const CONTRAST_MIN: f64 = 4.5;

/// Minimum text size on a screen, in CSS pixels. Assumption: smaller text is illegible on a phone.
const TEXT_PX_MIN: f64 = 8.0;

/// Script that finds text that is cut off, overlaps or is too small.
const LEGIBILITY: &str = r"(() => {
    const wrong = [];
    for (const svg of document.querySelectorAll('svg.plot, svg.timeline')) {
        const texts = [...svg.querySelectorAll('text')].filter(t => t.textContent.trim());
        const boxes = texts.map(t => [t, t.getBoundingClientRect()]);
        for (let i = 0; i < boxes.length; i++) {
            const [t, a] = boxes[i];
            const size = parseFloat(getComputedStyle(t).fontSize) * Math.hypot(t.getScreenCTM().a, t.getScreenCTM().b);
            if (size < MIN) wrong.push(`${svg.ariaLabel}: ${t.textContent.trim()} of ${size} px`);
            for (const [u, b] of boxes.slice(i + 1)) {
                const over = Math.min(Math.min(a.right, b.right) - Math.max(a.left, b.left),
                                      Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top));
                if (over > 1) wrong.push(`${svg.ariaLabel}: ${t.textContent.trim()} over ${u.textContent.trim()} by ${over} px`);
            }
        }
    }
    return wrong;
})()";

/// Script that finds text with too little contrast to its background.
const CONTRAST: &str = r"(() => {
    const rgb = text => {
        const parts = text.match(/[\d.]+/g).map(Number);
        if (text.startsWith('color(srgb')) parts.forEach((part, i) => { if (i < 3) parts[i] = part * 255; });
        return parts;
    };
    const over = (top, below) => {
        const alpha = top.length > 3 ? top[3] : 1;
        return [0, 1, 2].map(i => alpha * top[i] + (1 - alpha) * below[i]);
    };
    const linear = c => (c /= 255) <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
    const light = c => 0.2126 * linear(c[0]) + 0.7152 * linear(c[1]) + 0.0722 * linear(c[2]);
    const behind = element => element
        ? over(rgb(getComputedStyle(element).backgroundColor), behind(element.parentElement)) : [255, 255, 255];
    const wrong = [];
    for (const e of document.querySelectorAll('h1, h2, h3, p, td, th, dt, dd, code, a, span, figcaption, .verdict')) {
        if (!e.textContent.trim()) continue;
        const [a, b] = [light(rgb(getComputedStyle(e).color)), light(behind(e))];
        const contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
        if (contrast < MIN) wrong.push(`${e.tagName}.${e.className} ${e.textContent.slice(0, 40)}: ${contrast.toFixed(2)}`);
    }
    return [...new Set(wrong)].slice(0, 20);
})()";

fn browser() -> Option<Browser> {
    match program() {
        Some(program) => Some(Browser::start(&program)),
        None => {
            let how = "install the Debian package chromium";
            skips::skip_unless("HIL_TESTS_NEED_CHROMIUM", "no Chromium here", how);
            None
        }
    }
}

/// Opens the page; checks that it loads, reports no problems, and requests only itself.
fn open_alone(browser: &mut Browser, page: &Path) {
    let events = browser.open(page);
    let complaints: Vec<&Value> = events
        .iter()
        .filter(|event| COMPLAINTS.iter().any(|one| event["method"] == *one))
        .collect();
    assert!(complaints.is_empty(), "{}: {complaints:#?}", page.display());
    let asked = events.iter().filter(|event| event["method"] == "Network.requestWillBeSent");
    let asked: Vec<&str> =
        asked.filter_map(|event| event["params"]["request"]["url"].as_str()).collect();
    assert_eq!(asked, [format!("file://{}", page.display())]);
    assert!(browser.evaluate("document.body.innerText.length").as_u64() > Some(100));
}

/// Returns the problems of legibility.
fn illegible(browser: &mut Browser, page: &Path, view: &View) -> Vec<String> {
    let name = page.parent().and_then(Path::file_name).unwrap_or_default().display();
    let of = |wrong: String| format!("{name}, {}: {wrong}", view.name);
    let widest = "Math.max(document.documentElement.scrollWidth, window.innerWidth)";
    let widest = browser.evaluate(widest);
    let mut all = Vec::new();
    if widest != view.width {
        all.push(of(format!("{widest} px wide")));
    }
    let checks = [(LEGIBILITY, TEXT_PX_MIN), (CONTRAST, CONTRAST_MIN)];
    for (check, least) in checks {
        let wrong = browser.evaluate(&check.replace("MIN", &least.to_string()));
        let wrong = wrong.as_array().unwrap().iter();
        all.extend(wrong.map(|one| of(one.as_str().unwrap_or_default().to_owned())));
    }
    all
}

/// One test, for which the pages are made once and one browser is started.
#[test]
fn the_pages_in_a_browser() {
    let Some(mut browser) = browser() else { return };
    let pages = Pages::make();
    every_page_is_alone_and_legible_however_it_is_looked_at(&mut browser, &pages);
    every_page_goes_to_paper(&mut browser, &pages);
    text_from_outside_does_nothing(&mut browser, &pages);
}

fn every_page_is_alone_and_legible_however_it_is_looked_at(browser: &mut Browser, pages: &Pages) {
    let mut wrong = Vec::new();
    for page in pages.all() {
        for view in VIEWS {
            browser.look(&view);
            open_alone(browser, page);
            wrong.extend(illegible(browser, page, &view));
        }
        let mut ground = |view: &View| {
            browser.look(view);
            browser.evaluate("getComputedStyle(document.body).backgroundColor")
        };
        assert_ne!(ground(&VIEWS[0]), ground(&VIEWS[1]), "dark is not light");
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

fn every_page_goes_to_paper(browser: &mut Browser, pages: &Pages) {
    for page in pages.all() {
        browser.look(&VIEWS[0]);
        open_alone(browser, page);
        let data = browser.ask("Page.printToPDF", json!({ "printBackground": true }));
        let data = data["data"].as_str().unwrap();
        // "%PDF-" in base64.
        assert!(data.starts_with("JVBERi0"), "{}", &data[..20]);
        // Paper is white, with a dark screen too.
        browser.look(&View { media: "print", ..VIEWS[1] });
        let paper = browser.evaluate("getComputedStyle(document.body).backgroundColor");
        assert_eq!(paper, "rgb(255, 255, 255)");
    }
}

fn text_from_outside_does_nothing(browser: &mut Browser, pages: &Pages) {
    browser.look(&VIEWS[0]);
    for page in [&pages.hostile, &pages.campaign] {
        open_alone(browser, page);
        assert_eq!(browser.evaluate("document.images.length + document.scripts.length"), 0);
        assert_eq!(browser.evaluate("document.title.includes('hacked')"), false);
        let hidden =
            "/[\\u0000-\\u0008\\u202a-\\u202e\\u2066-\\u2069]/.test(document.body.innerText)";
        assert_eq!(browser.evaluate(hidden), false);
    }
    open_alone(browser, &pages.hostile);
    let title = browser.evaluate("document.querySelector('h1').innerText");
    assert_eq!(title, pages::HOSTILE_SHOWN);
}

/// Measures the loading time of each page, for docs/benchmarks.md.
#[test]
#[ignore = "measures"]
fn time_to_load() {
    let Some(mut browser) = browser() else { return };
    let pages = Pages::make();
    println!("| page | size (aim 5 MB) | loaded after (aim 2 s) |\n|---|---|---|");
    for page in pages.all() {
        open_alone(&mut browser, page);
        let loaded_ms =
            browser.evaluate("performance.getEntriesByType('navigation')[0].loadEventEnd");
        let bytes = std::fs::metadata(page).unwrap().len();
        let name = page.parent().and_then(Path::file_name).unwrap_or_default().display();
        println!(
            "| {name} | {:.0} kB | {:.0} ms |",
            bytes as f64 / 1e3,
            loaded_ms.as_f64().unwrap()
        );
    }
}
