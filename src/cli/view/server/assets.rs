//! Parts of the page, which the program contains.

const HTML: &str = "text/html; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";

/// Path, kind and content.
const ASSETS: [(&str, &str, &str); 14] = [
    ("", HTML, include_str!("../page/index.html")),
    ("icon.svg", "image/svg+xml", include_str!("../page/icon.svg")),
    ("style.css", STYLE, include_str!("../page/style.css")),
    ("main.js", SCRIPT, include_str!("../page/main.js")),
    ("accuracy.js", SCRIPT, include_str!("../page/accuracy.js")),
    ("bench.js", SCRIPT, include_str!("../page/bench.js")),
    ("camera.js", SCRIPT, include_str!("../page/camera.js")),
    ("controls.js", SCRIPT, include_str!("../page/controls.js")),
    ("drawing.js", SCRIPT, include_str!("../page/drawing.js")),
    ("histogram.js", SCRIPT, include_str!("../page/histogram.js")),
    ("link.js", SCRIPT, include_str!("../page/link.js")),
    ("orbit.js", SCRIPT, include_str!("../page/orbit.js")),
    ("save.js", SCRIPT, include_str!("../page/save.js")),
    ("screen.js", SCRIPT, include_str!("../page/screen.js")),
];

/// Returns the kind and the content of a part.
pub(super) fn find(path: &str) -> Option<(&'static str, &'static str)> {
    let found = ASSETS.iter().find(|(name, ..)| *name == path);
    found.map(|(_, kind, content)| (*kind, *content))
}
