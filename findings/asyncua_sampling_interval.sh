#!/usr/bin/env bash
# asyncua: the server ignores the sampling interval of a subscription.
#
# Guess: a client that asks for sampling_interval=500 ms gets at most two values a second.
# Version: asyncua 2.1.0.
# Behaviour: the server notifies every change of the value, at whatever rate, collected for each publishing interval; the
#   request is not used, and the server answers that it revised the sampling interval to the publishing interval. Only
#   queuesize limits the number: the last queuesize changes before each publication. Writing an equal value is no change and
#   is not notified.
# Output: 100 changes within 1 s and as many writes of an equal value, publishing interval 500 ms. sampling_interval 0, 500 and
#   5000 ms: 100 notifications each; 500 ms with queuesize=1: about 3.
# Why it matters: a simulated winder or a gateway built with asyncua shows a client many more values than the controller of the
#   real machine, which does sample. Means over notifications are means over changes, not over time, and a steady tension is
#   missing from them.
# Remedy: queuesize=1 for one value per publishing interval; weight values with the time until the next one.
. "$(dirname "$0")/environment" asyncua==2.1.0
python - <<'EOF'
import asyncio
import logging
import socket

from asyncua import Client, Server

logging.disable(logging.CRITICAL)
with socket.socket() as free:
    free.bind(("127.0.0.1", 0))
    url = f"opc.tcp://127.0.0.1:{free.getsockname()[1]}/"


class Received:
    def __init__(self):
        self.values = []

    def datachange_notification(self, node, value, data):
        self.values.append(value)


async def notifications(client, tension, **options):
    """Return the number of notifications of 100 changes and of 100 writes of an equal value."""
    await tension.write_value(0.0)
    received = Received()
    subscription = await client.create_subscription(500, received)
    await subscription.subscribe_data_change(client.get_node(tension.nodeid), **options)
    for k in range(200):
        await tension.write_value(float(min(k + 1, 100)))
        await asyncio.sleep(0.01)
    await asyncio.sleep(1.2)
    await subscription.delete()
    count = sum(value > 0 for value in received.values)
    print(options, count)
    return count


async def main():
    server = Server()
    await server.init()
    server.set_endpoint(url)
    tension = await server.nodes.objects.add_variable(await server.register_namespace("winder"), "tension", 0.0)
    async with server, Client(url) as client:
        counts = [await notifications(client, tension, sampling_interval=ms) for ms in (0.0, 500.0, 5000.0)]
        limited = await notifications(client, tension, sampling_interval=500.0, queuesize=1)
    if counts != [100, 100, 100] or limited > 10:
        raise SystemExit(f"changed: {counts}, {limited}")
    print("as stated")


asyncio.run(main())
EOF
