//! The files of the page: all of them are in the program, nothing is fetched from anywhere.

/// One file.
pub struct File {
    pub path: &'static str,
    pub kind: &'static str,
    pub text: &'static str,
}

const SCRIPT: &str = "text/javascript; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";

/// All of them.
pub const FILES: [File; 10] = [
    File { path: "/", kind: "text/html; charset=utf-8", text: include_str!("../page/scope.html") },
    File { path: "/scope.js", kind: SCRIPT, text: include_str!("../page/scope.js") },
    File { path: "/data.js", kind: SCRIPT, text: include_str!("../page/data.js") },
    File { path: "/picture.js", kind: SCRIPT, text: include_str!("../page/picture.js") },
    File { path: "/entry.js", kind: SCRIPT, text: include_str!("../page/entry.js") },
    File { path: "/chart.js", kind: SCRIPT, text: sinew_plot::web::CHART },
    File { path: "/uplot.js", kind: SCRIPT, text: sinew_plot::web::UPLOT },
    File { path: "/uplot.css", kind: STYLE, text: sinew_plot::web::UPLOT_STYLE },
    File { path: "/inks.css", kind: STYLE, text: sinew_plot::web::INKS },
    File { path: "/scope.css", kind: STYLE, text: include_str!("../page/scope.css") },
];
