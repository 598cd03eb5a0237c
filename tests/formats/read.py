"""Prints what pyarrow or the mcap package reads from a file, as JSON: columns by name, metadata."""

import json
import sys


def parquet(path):
    from pyarrow import parquet as pq

    table = pq.read_table(path)
    metadata = {k.decode(): v.decode() for k, v in (table.schema.metadata or {}).items()}
    types = {field.name: str(field.type) for field in table.schema}
    return {"columns": table.to_pydict(), "types": types, "metadata": metadata}


def mcap(path):
    from mcap.reader import make_reader

    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True)
        columns = {"log_time": []}
        topics, properties = set(), {}
        for schema, channel, message in reader.iter_messages():
            topics.add(channel.topic)
            assert (channel.message_encoding, schema.encoding) == ("json", "jsonschema")
            properties = json.loads(schema.data)["properties"]
            fields = json.loads(message.data)
            assert set(fields) <= set(properties), fields
            columns["log_time"].append(message.log_time)
            for name in properties:
                columns.setdefault(name, []).append(fields.get(name))
        metadata = {record.name: record.metadata for record in reader.iter_metadata()}
        count = reader.get_summary().statistics.message_count
    return {"columns": columns, "topics": sorted(topics), "metadata": metadata, "count": count}


if __name__ == "__main__":
    print(json.dumps({"parquet": parquet, "mcap": mcap}[sys.argv[1]](sys.argv[2])))
