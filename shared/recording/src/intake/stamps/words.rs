//! Words in dates: months, days of the week, halves of the day, zones.

const MONTHS: [&str; 12] = [
    "january",
    "february",
    "march",
    "april",
    "may",
    "june",
    "july",
    "august",
    "september",
    "october",
    "november",
    "december",
];
/// Months that begin otherwise in other languages.
const OTHER_MONTHS: &[(&str, u8)] = &[
    ("janv", 1),
    ("ene", 1),
    ("gen", 1),
    ("fév", 2),
    ("fev", 2),
    ("mär", 3),
    ("mrz", 3),
    ("mrt", 3),
    ("mars", 3),
    ("marz", 3),
    ("maa", 3),
    ("avr", 4),
    ("abr", 4),
    ("mai", 5),
    ("mei", 5),
    ("may", 5),
    ("mag", 5),
    ("juin", 6),
    ("juni", 6),
    ("giu", 6),
    ("juil", 7),
    ("juli", 7),
    ("lug", 7),
    ("aoû", 8),
    ("aou", 8),
    ("ago", 8),
    ("augu", 8),
    ("sept", 9),
    ("set", 9),
    ("okt", 10),
    ("oct", 10),
    ("ott", 10),
    ("nov", 11),
    ("dez", 12),
    ("déc", 12),
    ("dec", 12),
    ("dic", 12),
];
const DAYS: [&str; 7] = ["monday", "tuesday", "wednesday", "thursday", "friday", "saturday", "sunday"];
/// Zones by name, and how far they are ahead of UTC [min]; names of several zones are absent.
const ZONES: &[(&str, i64)] = &[
    ("Z", 0),
    ("UTC", 0),
    ("UT", 0),
    ("GMT", 0),
    ("WET", 0),
    ("WEST", 60),
    ("CET", 60),
    ("MEZ", 60),
    ("CEST", 120),
    ("MESZ", 120),
    ("EET", 120),
    ("EEST", 180),
    ("MSK", 180),
    ("JST", 540),
    ("KST", 540),
    ("AEST", 600),
    ("AEDT", 660),
    ("EST", -300),
    ("EDT", -240),
    ("CDT", -300),
    ("MST", -420),
    ("MDT", -360),
    ("PST", -480),
    ("PDT", -420),
];

/// What a word in a date is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Word {
    Month(u8),
    Weekday,
    Afternoon(bool),
    /// Seconds ahead of UTC.
    Zone(i64),
    /// The number before it is one of days.
    Days,
    /// Divides date and time.
    Time,
}

impl Word {
    pub fn of(word: &str) -> Option<Self> {
        if let Some((_, minutes)) = ZONES.iter().find(|(zone, _)| zone.eq_ignore_ascii_case(word)) {
            return Some(Word::Zone(60 * minutes));
        }
        let small = word.to_lowercase();
        match small.as_str() {
            "t" => return Some(Word::Time),
            "am" | "오전" | "上午" | "午前" => return Some(Word::Afternoon(false)),
            "pm" | "오후" | "下午" | "午後" => return Some(Word::Afternoon(true)),
            "day" | "days" | "d" => return Some(Word::Days),
            _ => {}
        }
        let named = |name: &&str| small.chars().count() >= 3 && name.starts_with(&small);
        let month = MONTHS.iter().position(named).map(|at| at as u8 + 1);
        let other = || OTHER_MONTHS.iter().find(|(name, _)| small.starts_with(name)).map(|(_, month)| *month);
        let weekday = || DAYS.iter().any(named).then_some(Word::Weekday);
        month.or_else(other).map(Word::Month).or_else(weekday)
    }
}
