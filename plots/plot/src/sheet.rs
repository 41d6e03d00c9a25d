//! The common layout of the project's pages: one file with its styles inside, a heading, links to its sections.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::ink::DASHES;
use crate::web::INKS;

/// Styles, and nothing else: nothing is run, nothing is fetched.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'";

/// The head of a page that stands alone: its styles are inside, and `policy` is what it may do.
pub fn head(title: &str, policy: &str, styles: &[&str]) -> Markup {
    html! {
        head {
            meta charset="utf-8";
            meta name="viewport" content="width=device-width, initial-scale=1";
            meta http-equiv="Content-Security-Policy" content=(policy);
            title { (title) }
            style { @for style in styles { (PreEscaped(style)) } }
        }
    }
}

/// A page.
pub struct Sheet {
    /// In the window's title.
    pub title: String,
    /// Class of the body, by which the style sheet knows what kind of answer it is.
    pub class: &'static str,
    /// On top, beside the links.
    pub heading: Markup,
    /// In this order.
    pub sections: Vec<Section>,
}

/// A section of a page. Its body is a `section` element whose id is the link's.
pub struct Section {
    /// The id and the name of the link to it.
    link: Option<(&'static str, &'static str)>,
    body: Markup,
}

impl Section {
    /// A section that is linked to by this id and name.
    pub fn new(id: &'static str, name: &'static str, body: Markup) -> Section {
        Section { link: Some((id, name)), body }
    }

    /// One that needs no link.
    pub fn unlisted(body: Markup) -> Section {
        Section { link: None, body }
    }
}

impl Sheet {
    /// The whole page.
    pub fn page(self) -> Markup {
        html! {
            (DOCTYPE)
            html lang="en" {
                (head(&self.title, POLICY, &[INKS, include_str!("style.css"), DASHES]))
                body class=(self.class) {
                    header {
                        p.rig { (self.heading) }
                        nav aria-label="Sections" {
                            @for (id, name) in self.sections.iter().filter_map(|section| section.link) {
                                a href={ "#" (id) } { (name) }
                            }
                        }
                    }
                    main { @for section in &self.sections { (section.body) } }
                }
            }
        }
    }
}
