//! Small tutorials.

use super::*;

fn try_play(text: &str) -> Result<Played> {
    play(text, &std::env::var_os("PATH").expect("a PATH"), Duration::from_secs(20))
}

#[track_caller]
fn played(text: &str) -> Played {
    try_play(text).expect("a tutorial that runs")
}

#[track_caller]
fn check_differences(text: &str, expected: &[&str]) {
    assert_eq!(played(text).differences, expected);
}

#[track_caller]
fn check_error(text: &str, expected: &str) {
    let error = try_play(text).err().expect("a tutorial that does not run");
    assert_eq!(format!("{error:#}"), expected);
}

#[test]
fn what_is_printed_as_written_is_in_order() {
    check_differences("Say:\n\n```sh\necho a; echo b\n```\n\n```text\na\nb\n```\n", &[]);
}

#[test]
fn blanks_at_the_ends_do_not_matter() {
    check_differences("```sh\nprintf 'a  \\nb\\n\\n\\n'\n```\n```text\na\nb \n\n```\n", &[]);
}

#[test]
fn another_text_is_shown_with_its_place_and_only_where_it_differs() {
    let text = "# A\n\n```sh\necho 1\n```\n\n```sh\nprintf 'a\\nB\\nc\\n'\n```\n\n```text\na\nb\nbb\nc\n```\n";
    check_differences(text, &["line 7, block 2: printed something else\n  - b\n  - bb\n  + B"]);
}

#[test]
fn missing_and_additional_lines_are_differences() {
    check_differences(
        "```sh\necho a; echo a\n```\n```text\na\n```\n",
        &["line 1, block 1: printed something else\n  + a"],
    );
    check_differences("```sh\n:\n```\n```text\na\n```\n", &["line 1, block 1: printed something else\n  - a"]);
}

#[test]
fn errors_are_printed_between_the_lines_of_the_output() {
    check_differences("```sh\necho a; echo b >&2; echo c\n```\n```text\na\nb\nc\n```\n", &[]);
}

#[test]
fn text_after_words_or_another_block_is_not_compared() {
    check_differences("```sh\necho a\n```\n\nWords.\n\n```text\nb\n```\n", &[]);
    check_differences("```sh\necho a\n```\n```toml\nx = 1\n```\n```text\nb\n```\n", &[]);
}

#[test]
fn block_finds_the_files_and_the_directory_of_the_block_before() {
    let text = "```sh\nmkdir d; cd d; echo x >f\n```\n```sh\ncat f; basename \"$PWD\"\n```\n```text\nx\nd\n```\n";
    check_differences(text, &[]);
}

#[test]
fn each_tutorial_starts_in_an_empty_folder() {
    for _ in 0..2 {
        check_differences("```sh\nls -A; touch left-over\n```\n```text\n```\n", &[]);
    }
}

#[test]
fn ignored_block_is_not_run() {
    check_differences("```sh ignore\nexit 3\n```\n```text\nno\n```\n```sh\necho a\n```\n```text\na\n```\n", &[]);
}

#[test]
fn block_that_fails_ends_the_tutorial() {
    let text = "```sh\necho so far; false; echo never\n```\n```sh\necho b\n```\n```text\na\n```\n";
    check_error(text, "line 1, block 1: ended with exit code 1; it printed\nso far");
}

#[test]
fn unset_variable_is_a_failure() {
    let error = try_play("```sh\necho $no_such_variable\n```\n").err().expect("`sh -u`");
    assert!(format!("{error:#}").starts_with("line 1, block 1: ended with exit code"), "{error:#}");
}

#[test]
fn block_that_should_fail_must() {
    check_differences("```sh fails\necho a; exit 2\n```\n```text\na\n```\n", &[]);
    check_error(
        "```sh fails\necho a\n```\n",
        "line 1, block 1: ended with exit code 0, but is marked `fails`; it printed\na",
    );
}

#[test]
fn block_that_does_not_end_is_ended_with_all_it_started() {
    let limit = Duration::from_millis(300);
    let path = std::env::var_os("PATH").expect("a PATH");
    let error = play("```sh\necho a; sleep 1000 | cat\n```\n", &path, limit).err().expect("too slow");
    assert_eq!(format!("{error:#}"), "line 1, block 1: not done after 0.3 s; it printed\na");
}

#[test]
fn what_a_block_leaves_running_ends_with_it() {
    check_differences("```sh\nsleep 1000 &\necho a\n```\n```text\na\n```\n", &[]);
}

#[test]
fn own_programs_come_first() {
    let path = search_path(&[PathBuf::from("first"), PathBuf::from("second")]).expect("a PATH");
    let folders: Vec<PathBuf> = std::env::split_paths(&path).collect();
    assert_eq!(folders[..2], [PathBuf::from("first"), PathBuf::from("second")]);
    assert!(folders.len() > 2, "the programs of the system follow");
}

#[test]
fn written_text_holds_what_was_printed_and_then_passes() {
    let text = "Words.\n\n```sh\necho a\n```\n\n```text\nold\nlines\n```\n\n```sh\necho b\n```\n```text\n```\nEnd.\n";
    let written = played(text).text;
    assert_eq!(
        written,
        "Words.\n\n```sh\necho a\n```\n\n```text\na\n```\n\n```sh\necho b\n```\n```text\nb\n```\nEnd.\n"
    );
    check_differences(&written, &[]);
}

#[test]
fn printed_fence_cannot_be_written() {
    check_error("```sh\necho '```'\n```\n```text\n```\n", "line 4: what was printed would end its own block");
}

#[test]
fn longer_fence_holds_shorter_ones() {
    check_differences("````md\n```sh\nexit 1\n```\n````\n```sh\necho a\n```\n```text\na\n```\n", &[]);
}

#[test]
fn what_is_no_tutorial_is_refused() {
    check_error("Words.\n", "no block to run");
    check_error("```sh\necho a\n", "line 1: a fence without an end");
    check_error("```sh failing\n```\n", "line 1: `sh failing`: it must be sh, sh fails or sh ignore");
}

#[test]
fn folder_without_tutorials_is_an_error() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("tutorial-rig.md"), "").expect("a file");
    let error = tutorials(folder.path()).expect_err("none of the name");
    assert!(error.to_string().ends_with("no tutorial-campaign-*.md"), "{error}");
    for name in ["tutorial-campaign-b.md", "tutorial-campaign-a.md", "tutorial-campaign-circuit.md"] {
        fs::write(folder.path().join(name), "").expect("a file");
    }
    let names: Vec<_> =
        tutorials(folder.path()).expect("two").iter().map(|path| path.file_name().map(OsString::from)).collect();
    assert_eq!(names, ["tutorial-campaign-a.md", "tutorial-campaign-b.md"].map(|name| Some(OsString::from(name))));
}
