//! How much a diagnosis may compute: the only place that knows what an effort is.

use identification::work::{LIMIT_NOTE, NORMAL_WORK, QUICK_WORK};

/// The limit of a diagnosis, in counted work ([`identification::work`]), the same on every machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Effort {
    /// A fifth of normal
    Quick,
    /// About two minutes of one core
    #[default]
    Normal,
    /// Ten times normal
    Thorough,
}

impl Effort {
    /// `quick`, `normal`, `thorough`.
    pub fn name(self) -> &'static str {
        match self {
            Effort::Quick => "quick",
            Effort::Normal => "normal",
            Effort::Thorough => "thorough",
        }
    }

    /// Multiple of the normal work.
    fn factor(self) -> f64 {
        match self {
            Effort::Quick => QUICK_WORK / NORMAL_WORK,
            Effort::Normal => 1.0,
            Effort::Thorough => 10.0,
        }
    }

    /// The most that a diagnosis may cost.
    pub fn work(self) -> f64 {
        self.factor() * NORMAL_WORK
    }

    fn next(self) -> Option<Self> {
        match self {
            Effort::Quick => Some(Effort::Normal),
            Effort::Normal => Some(Effort::Thorough),
            Effort::Thorough => None,
        }
    }

    /// Adds the next effort as the cure to notes that say what the limit left out.
    pub fn cure(self, notes: &mut [String]) {
        let Some(next) = self.next() else { return };
        for note in notes.iter_mut().filter(|note| note.contains(LIMIT_NOTE)) {
            let times = (next.factor() / self.factor()).round();
            note.push_str(&format!("; --effort {} does {times} times the work", next.name()));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quick_is_a_fifth_of_normal_and_thorough_ten_times() {
        let [quick, normal, thorough] = [Effort::Quick, Effort::Normal, Effort::Thorough].map(Effort::work);
        assert!(normal == NORMAL_WORK && 5.0 * quick == normal && thorough == 10.0 * normal);
        assert_eq!(Effort::default(), Effort::Normal);
    }

    #[test]
    fn a_note_of_the_limit_names_the_next_effort_and_no_other_note_does() {
        let cured = |effort: Effort| {
            let mut notes = [format!("{LIMIT_NOTE}a"), "b".to_owned()];
            effort.cure(&mut notes);
            notes
        };
        assert!(cured(Effort::Quick)[0].ends_with("a; --effort normal does 5 times the work"));
        assert!(cured(Effort::Normal)[0].ends_with("a; --effort thorough does 10 times the work"));
        assert!(cured(Effort::Thorough)[0].ends_with(": a"));
        assert_eq!(cured(Effort::Quick)[1], "b");
    }
}
