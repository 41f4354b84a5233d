"""Makes one JUnit file of several: python merge_junit.py ALL.xml FILE..."""

import sys
import xml.etree.ElementTree as tree

into, *files = sys.argv[1:]
root = tree.Element("testsuites")
for file in files:
    read = tree.parse(file).getroot()
    root.extend(read.iter("testsuite"))
tree.ElementTree(root).write(into, encoding="utf-8", xml_declaration=True)
