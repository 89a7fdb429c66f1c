"""Counts catkin's junit files; fails on failures, on no test, on a wrongly skipped one."""

import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

ALLOWED_SKIPS = (  # all else that is missing is a failure
    "recording",  # they are not part of the package
    "no network namespaces here",  # a matter of the user's rights and the kernel
)


def main(folder: str) -> int:
    passed, failed, skipped, wrong_skips = 0, 0, 0, []
    for file in sorted(Path(folder).rglob("*.xml")):
        for case in ElementTree.parse(file).iter("testcase"):
            skip = case.find("skipped")
            if skip is not None:
                skipped += 1
                reason = f"{skip.get('message')} {skip.text}"
                if not any(allowed in reason for allowed in ALLOWED_SKIPS):
                    wrong_skips.append(f"{case.get('classname')}.{case.get('name')}: {reason}")
            elif case.find("failure") is not None or case.find("error") is not None:
                failed += 1
            else:
                passed += 1
    for line in wrong_skips:
        print(f"skipped, and must not be: {line}")
    print(f"{passed} passed, {failed + len(wrong_skips)} failed, {skipped} skipped")
    return 0 if passed and not failed and not wrong_skips else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
