//! Head and foot of pages: HTML without scripts or other files, as well-formed XML, so that tests and tools can read it.

use std::fmt::Write as _;

use crate::date::now;
use crate::svg::escape;

const STYLE: &str = "
:root { color-scheme: light dark; }
body { font: 16px/1.5 Helvetica, Arial, sans-serif; max-width: 64rem; margin: 2rem auto; \
padding: 0 1rem; color: CanvasText; background: Canvas; }
h1 { font-size: 1.6rem; margin-bottom: 0.2rem; } h2 { font-size: 1.2rem; margin-top: 2.4rem; }
p { max-width: 46rem; } .note { font-size: 0.85rem; opacity: 0.8; }
nav { display: flex; flex-wrap: wrap; gap: 0.2rem 1rem; font-size: 0.9rem; }
svg { width: 100%; height: auto; }
.drawing { background: #fff; padding: 0.5rem; }
.plots { display: grid; grid-template-columns: repeat(auto-fill, minmax(22rem, 1fr)); gap: 1rem; }
.square { grid-template-columns: repeat(auto-fill, minmax(18rem, 1fr)); }
.narrow { max-width: 20rem; } .broad { grid-column: 1 / -1; }
.plots figure { margin: 0; }
figcaption { font-size: 0.85rem; font-weight: bold; }
table { border-collapse: collapse; font-size: 0.8rem; font-variant-numeric: tabular-nums; \
margin: 0.8rem 0; max-width: 100%; }
th, td { text-align: right; padding: 0.15rem 0.6rem; \
border-bottom: 1px solid color-mix(in srgb, currentColor 25%, transparent); }
th { vertical-align: bottom; } .words { text-align: left; }
th:first-child, td:first-child { text-align: left; }
tr.stop td { font-weight: bold; } tr.sum td { border-top: 2px solid; font-weight: bold; }
footer { margin-top: 3rem; border-top: 1px solid; }
@media print {
:root { color-scheme: light; } body { max-width: none; margin: 0; font-size: 11pt; }
nav { display: none; } h2 { break-after: avoid; } figure, tr, .drawing { break-inside: avoid; }
.plots { grid-template-columns: repeat(2, 1fr); } .square { grid-template-columns: repeat(3, 1fr); }
svg, rect { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
}
@page { margin: 15mm; }
";

/// Returns the beginning of a page.
pub(crate) fn begin(title: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <title>{}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n",
        escape(title)
    )
}

/// Ends a page with the version, the time and the command that made it.
pub(crate) fn end(page: &mut String, command: &str) {
    let _ = writeln!(
        page,
        "<footer><p class=\"note\">petzval {}, {}<br/>The command: {}</p></footer>\n</body>\n</html>",
        env!("CARGO_PKG_VERSION"),
        now(),
        escape(command)
    );
}
