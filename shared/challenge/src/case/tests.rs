use super::*;

#[test]
fn a_case_is_a_function_of_its_seed_and_number() {
    for number in [0, 1] {
        let (a, b) = (case(3, number), case(3, number));
        assert_eq!((&a.truth, &a.digest), (&b.truth, &b.digest));
        assert_eq!(recording_digest(&a.exam.recording), recording_digest(&b.exam.recording));
        assert_ne!(a.digest, case(4, number).digest);
    }
}

#[test]
fn a_changed_truth_has_another_digest() {
    let sealed = case(3, 0);
    let mut truth = sealed.truth.clone();
    assert_eq!(digest(&truth), sealed.digest);
    truth[20] ^= 1;
    assert_ne!(digest(&truth), sealed.digest);
}

#[test]
fn ten_cases_hold_three_nulls_and_one_of_each_special_class() {
    let classes: Vec<Class> = (0..10).map(draw::class_of).collect();
    let count = |class| classes.iter().filter(|c| **c == class).count();
    assert_eq!((count(Class::Null), count(Class::Pair)), (3, 1));
    assert_eq!((count(Class::LeftOut), count(Class::Masked), count(Class::Single)), (1, 1, 4));
}
