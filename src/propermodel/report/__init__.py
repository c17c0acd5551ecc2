"""The report room: the study of a reduction, and its summary, tables and figures."""
