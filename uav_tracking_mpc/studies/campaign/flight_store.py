# Copyright 2026 uav_tracking_mpc maintainers
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""Results on disk: a file for each batch as it finishes, at the end one Parquet file of all."""

from __future__ import annotations

import io
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.report.atomic_write import write_atomically
from uav_tracking_mpc.studies.campaign.campaign_file import Campaign
from uav_tracking_mpc.studies.campaign.one_flight import Row, Task
from uav_tracking_mpc.studies.comparison.law_names import law_label

if TYPE_CHECKING:
    import pyarrow

FILE = "flights.parquet"
IDENTITY = b"campaign"  # under which a file's metadata hold the campaign's digest
FIGURES = (
    "settled_s", "worst_settled_m", "range_rms_m", "range_mean_m", "worst_m", "altitude_rms_m",
    "airspeed_rms_mps", "bank_rate_rms_dps",
)  # fmt: skip


class FlightStore:
    """The folder of a campaign.

    Args:
        campaign: Whose results it holds.
        folder: Made if it is not there.

    Attributes:
        file: Where all results are at the end.

    Raises:
        ParameterError: The folder holds another campaign.
        OSError: It cannot be made or read.
    """

    def __init__(self, campaign: Campaign, folder: Path) -> None:
        self.file = folder / FILE
        self._campaign, self._parts = campaign, folder / "batches"
        self._schema = _schema(campaign)
        folder.mkdir(parents=True, exist_ok=True)
        self._rows: dict[Task, Row] = {}
        files = [*sorted(self._parts.glob("*.parquet")), *([self.file] * self.file.exists())]
        for file in files:
            self._read(file)

    def _read(self, file: Path) -> None:
        from pyarrow import ArrowException, parquet

        try:
            table = parquet.ParquetFile(file).read()
        except ArrowException as error:
            raise ParameterError(f"{file} is no Parquet file of a campaign: {error}") from error
        if table.schema.metadata is None or table.schema.metadata.get(IDENTITY) != self._identity:
            raise ParameterError(
                f"{file} holds flights of another campaign or version: take another --output, or "
                "remove them"
            )
        for row in table.to_pylist():
            self._rows[row["flight"], row["law"]] = row

    @property
    def _identity(self) -> bytes:
        return self._campaign.identity.encode()

    @property
    def empty(self) -> bool:
        """Whether it holds no flight."""
        return not self._rows

    def left(self) -> list[Task]:
        """Flights that have not been flown, with their laws, in order."""
        return [
            (number, law)
            for number in range(self._campaign.total)
            for law in self._campaign.laws
            if (number, law_label(law)) not in self._rows
        ]

    def keep(self, rows: Sequence[Row]) -> None:
        """Keep a batch, at once and whole.

        Args:
            rows: Of its flights, at least one.

        Raises:
            OSError: The folder cannot be written to.
        """
        self._parts.mkdir(exist_ok=True)
        first = rows[0]
        write_atomically(
            self._parts / f"{first['flight']:09d}_{first['law']}.parquet", self._content(rows)
        )
        self._rows.update({(row["flight"], row["law"]): row for row in rows})

    def finish(self) -> list[Row]:
        """Write one file of all and remove the batches.

        Returns:
            All rows, by number and law.

        Raises:
            OSError: The folder cannot be written to.
        """
        laws = [law_label(law) for law in self._campaign.laws]
        rows = sorted(self._rows.values(), key=lambda row: (row["flight"], laws.index(row["law"])))
        if self._parts.exists() or not self.file.exists():
            write_atomically(self.file, self._content(rows))
            shutil.rmtree(self._parts, ignore_errors=True)
        return rows

    def _content(self, rows: Sequence[Row]) -> bytes:
        import pyarrow
        from pyarrow import parquet

        schema = self._schema.with_metadata({IDENTITY: self._identity})
        table = pyarrow.Table.from_pylist(list(rows), schema=schema)
        buffer = io.BytesIO()
        parquet.write_table(table, buffer)
        return buffer.getvalue()


def _schema(campaign: Campaign) -> pyarrow.Schema:
    """Columns: flight, law and group; what was drawn; what came of it."""
    import pyarrow

    words = campaign.words
    kinds: dict[str, Any] = {"flight": pyarrow.int64()}
    kinds |= {name: pyarrow.string() for name in ("law", "group", "mistake")}
    for key in campaign.inputs:
        kinds[key] = pyarrow.string() if key in words else pyarrow.float64()
    kinds |= {"failed": pyarrow.bool_(), "reasons": pyarrow.string(), "error": pyarrow.string()}
    kinds |= {name: pyarrow.float64() for name in FIGURES}
    counts = ("envelope_violations", "solves_failed", "off_plan")
    kinds |= {name: pyarrow.int64() for name in counts}
    return pyarrow.schema(list(kinds.items()))
