//! Files that are there whole or not at all, whatever happens to the machine.

use std::io::{self, ErrorKind, Write as _};
use std::path::Path;

use anyhow::{Result, anyhow};

/// Puts a whole file in its place, so that nobody ever sees half of it.
pub(crate) fn replace(path: &Path, bytes: &[u8]) -> Result<()> {
    let fault = |error| unusable(path, &error);
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut file = tempfile::Builder::new().prefix(".infuse-").tempfile_in(folder).map_err(fault)?;
    file.write_all(bytes).and_then(|()| file.as_file().sync_all()).map_err(fault)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        file.as_file().set_permissions(std::fs::Permissions::from_mode(0o644)).map_err(fault)?;
    }
    file.persist(path).map_err(|error| fault(error.error))?;
    keep_name(path);
    Ok(())
}

/// Why a file of a campaign cannot be read or written, and what to do about it.
pub(crate) fn unusable(path: &Path, error: &io::Error) -> anyhow::Error {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let what_to_do = match error.kind() {
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => format!(
            "; get the right to read and write in {}, or copy the folder to where you have it",
            folder.display()
        ),
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => "; make room on the disk and try again".to_owned(),
        ErrorKind::IsADirectory => "; a folder stands where a file is expected: move it away".to_owned(),
        ErrorKind::NotADirectory => format!("; {} is no folder, expected the folder of a campaign", folder.display()),
        ErrorKind::NotFound => format!("; there is no folder {}, expected one that is there", folder.display()),
        ErrorKind::Unsupported => format!(
            "; {} cannot be locked for one process at a time, as on some drives of a network: copy it to a disk of this machine",
            folder.display()
        ),
        _ => String::new(),
    };
    anyhow!("{}: {error}{what_to_do}", path.display())
}

/// Makes sure that a new file is found again after a loss of power, where the system lets a folder be written down by itself. The
/// file is there in any case, so that a system that refuses has done no harm.
pub(crate) fn keep_name(path: &Path) {
    #[cfg(unix)]
    {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let _ = std::fs::File::open(folder).and_then(|folder| folder.sync_all());
    }
    #[cfg(not(unix))]
    let _ = path;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_may_not_write_is_told_where_and_what_to_do() {
        let said = |kind: ErrorKind| unusable(Path::new("rig/journal.jsonl"), &io::Error::from(kind)).to_string();
        for kind in [ErrorKind::PermissionDenied, ErrorKind::ReadOnlyFilesystem] {
            let said = said(kind);
            assert!(said.starts_with("rig/journal.jsonl: "), "{said}");
            assert!(
                said.ends_with("; get the right to read and write in rig, or copy the folder to where you have it"),
                "{said}"
            );
        }
        assert!(said(ErrorKind::StorageFull).ends_with("; make room on the disk and try again"));
        assert!(said(ErrorKind::Unsupported).contains("; rig cannot be locked"));
        assert_eq!(said(ErrorKind::FileTooLarge), "rig/journal.jsonl: file too large", "nothing but what happened");
        let here = unusable(Path::new("journal.jsonl"), &io::Error::from(ErrorKind::PermissionDenied)).to_string();
        assert!(here.contains("read and write in ., or"), "{here}");
    }
}
