//! All that is measured of a workspace, once for all tests.

use crate::house::{House, root};
use crate::tree::Tree;
use crate::{
    circles, constants, front_pages, matches_on_kinds, one_of_each, public_names, sizes, wide_comments, wording,
};
use std::sync::OnceLock;

/// The findings of every checker.
pub struct Findings {
    pub circles: circles::Circles,
    pub constants: constants::Constants,
    pub matches: matches_on_kinds::Matches,
    pub names: public_names::PublicNames,
    pub pages: front_pages::Pages,
    pub sizes: sizes::Sizes,
    /// Named methods that are written a second time.
    pub twice: Vec<String>,
    pub wide_comments: Vec<String>,
    pub wording: Vec<String>,
}

impl Findings {
    /// Runs every checker once.
    pub fn of(house: &House) -> Self {
        Self {
            circles: circles::measure(house),
            constants: constants::measure(house),
            matches: matches_on_kinds::measure(house),
            names: public_names::measure(house),
            pages: front_pages::measure(house),
            sizes: sizes::measure(house),
            twice: one_of_each::measure(house),
            wide_comments: wide_comments::measure(house),
            wording: wording::measure(house),
        }
    }
}

/// Of the workspace at [`root`]. Parsed trees cannot go from thread to thread, what is found can.
pub fn findings() -> &'static Findings {
    static FINDINGS: OnceLock<Findings> = OnceLock::new();
    FINDINGS.get_or_init(|| {
        let root = root();
        let house = House::of(&Tree::read(&root));
        assert!(house.members().next().is_some(), "no crates below {}", root.display());
        Findings::of(&house)
    })
}
