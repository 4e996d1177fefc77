"""The import-linter contract "a core knows no ROS", by the names of the modules.

import-linter's own contracts list modules one by one; here the name decides, so a new node or
a new core needs no entry anywhere.
"""

import re
from typing import Any, ClassVar

from grimp import ImportGraph
from importlinter import Contract, ContractCheck, fields, output

Violation = tuple[str, str, int]


class RosRoomsContract(Contract):
    """Modules that touch ROS are imported by nothing but ``rooms``.

    Configuration: ``ros_modules`` and ``rooms`` are lists of regular expressions that must
    match a module's whole name.
    """

    type_name: ClassVar[str] = "ros_rooms"

    # A field's value takes its place when the contract is made.
    ros_modules: Any = fields.ListField(subfield=fields.StringField())
    rooms: Any = fields.ListField(subfield=fields.StringField())

    def check(self, graph: ImportGraph, verbose: bool) -> ContractCheck:
        """Return every import of a ROS module from outside the rooms."""
        is_ros = re.compile("|".join(self.ros_modules)).fullmatch
        is_room = re.compile("|".join(self.rooms)).fullmatch
        violations: list[Violation] = []
        for importer in sorted(graph.modules):
            if graph.is_module_squashed(importer) or is_room(importer):
                continue
            for imported in sorted(graph.find_modules_directly_imported_by(importer)):
                if is_ros(imported):
                    details = graph.get_import_details(importer=importer, imported=imported)
                    violations += [(importer, imported, line["line_number"]) for line in details]
        output.verbose_print(verbose, f"{len(violations)} imports of ROS outside its rooms")
        return ContractCheck(kept=not violations, metadata={"violations": violations})

    def render_broken_contract(self, check: ContractCheck) -> None:
        """Print what imports ROS and must not."""
        output.print_error(
            "Only nodes, bha_common.ros_* and the client of the graph may import ROS:"
        )
        for importer, imported, line in check.metadata["violations"]:
            output.print_error(f"- {importer} -> {imported} (line {line})", bold=False)
