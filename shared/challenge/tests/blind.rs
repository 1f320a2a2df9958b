//! Ten blind cases: what must always hold, whatever the tool is worth.

use challenge::campaign::{Draws, Watch, campaign};
use challenge::case::Class;
use challenge::score::{Opened, is_false_alarm, score};
use std::sync::Mutex;

const CASES: u64 = 10;

fn run(cases: u64, threads: usize) -> (Vec<Opened>, Vec<String>) {
    let told = Mutex::new((0, 0));
    let mut digests = Vec::new();
    let mut watch = Watch {
        progress: &|what, done, all| {
            assert!(done <= all);
            let mut told = told.lock().unwrap();
            if what == "sealed" {
                assert_eq!(told.1, 0, "a truth was drawn after a diagnosis had begun");
                told.0 += 1;
            } else {
                told.1 += 1;
            }
        },
        seconds: &|| 0.0,
        sealed: &mut |sealed| digests = sealed.iter().map(|sealed| sealed.digest.clone()).collect(),
    };
    let opened = campaign(cases, (11, Draws::Blind), threads, &mut watch).unwrap();
    assert_eq!(*told.lock().unwrap(), (cases as usize, cases as usize));
    (opened, digests)
}

#[test]
fn ten_cases_are_sealed_answered_opened_and_counted() {
    let (opened, digests) = run(CASES, 2);
    assert_eq!(digests.len(), CASES as usize);
    for (number, (opened, digest)) in opened.iter().zip(&digests).enumerate() {
        assert_eq!((opened.truth.case, &opened.digest), (number as u64, digest));
        assert!(!opened.answer.crashed, "case {number} of {}", opened.truth.plant);
        let planned = opened.truth.planned_d;
        assert!(opened.truth.d.iter().all(|d| *d > 0.6 * planned && *d < 1.7 * planned), "{:?}", opened.truth);
        assert_eq!(opened.truth.class == Class::Null, opened.truth.effects.is_empty());
    }
    let figures = score(&opened);
    assert_eq!((figures.cases, figures.nulls), (10, 3));
    let alarms = opened.iter().filter(|o| is_false_alarm(&o.truth, &o.answer)).count();
    assert_eq!(figures.false_alarms, alarms);
    let known = opened.iter().filter(|o| matches!(o.truth.class, Class::Single | Class::Masked)).count();
    assert_eq!(figures.power.iter().map(|bin| bin.n).sum::<usize>(), known);
    for bin in &figures.power {
        assert!(bin.detected <= bin.n && bin.ideal <= bin.n as f64 && bin.ideal >= 0.0);
    }
    assert!(figures.leave_one_out.n <= 2 && figures.pairs.n <= 2 && figures.masked.n <= 2);
    assert!(figures.leave_one_out.abstained + figures.leave_one_out.false_name <= figures.leave_one_out.n);
    println!("{}", serde_json::to_string_pretty(&figures).unwrap());
}

#[test]
fn threads_change_nothing() {
    let bytes = |threads| serde_json::to_vec(&run(2, threads).0).unwrap();
    assert_eq!(bytes(1), bytes(2));
}
