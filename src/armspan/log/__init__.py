"""A session as an MCAP file: write it, read it, recover what a crash left, export it as tables.

The file, so that other tools can read it too:

- a Metadata record ``armspan`` right behind the file's Header: the session's header, each value as JSON;
- one channel per record type, topic ``/armspan/<type>``, messages in JSON, described by a JSON Schema;
- ``sequence`` numbers the records over all channels and *is* the order of the session; ``log_time`` is the
  arrival on the session's clock [ns], ``publish_time`` the record's ``t`` [ns]; ``t`` itself stands, exact,
  in the message and is never derived from nanoseconds;
- no chunks: a file that was cut in mid-write holds every record up to the last whole one.

Equal records give equal bytes.
"""

from armspan.log.reader import LogFile, read, recover
from armspan.log.tables import export_csv
from armspan.log.writer import LogWriter

__all__ = ["LogFile", "LogWriter", "export_csv", "read", "recover"]
