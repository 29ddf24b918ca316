"""A cart on a rail as a simulator of `fdiag gap`: docs/process-protocol.md in thirty lines of Python."""
import json, math, struct, sys

TS, ask, answer = 0.01, sys.stdin.buffer, sys.stdout.buffer
HELLO = {
    "version": 1, "name": "cart", "sample_time": TS,
    "inputs": [{"name": "force", "unit": "N"}],
    "outputs": [{"name": "speed", "unit": "m/s", "noise": 0.004}],
    "parameters": [{"name": "m", "unit": "kg", "value": 1.2, "tolerance": 0.03},
                   {"name": "d", "unit": "N s/m", "value": 1.5, "tolerance": 0.1}],
    "states": [{"name": "v", "unit": "m/s", "initial": 0.0}],
    "ports": [{"name": "rail", "unit": "N", "velocity": "speed"}],
    "powers": {"rollout": True, "measure": True, "states": True},
}

def step(theta, v, force, push):                      # exact for inputs that are held
    m, d = theta
    aim = (force + push) / d
    return aim + (v - aim) * math.exp(-d / m * TS)

ask.readline()                                        # what the model file says, which is all known here
answer.write((json.dumps(HELLO) + "\n").encode())
answer.flush()
while head := ask.read(12):
    op, lanes, count = struct.unpack("<III", head)
    a = struct.unpack(f"<{count}d", ask.read(8 * count))
    if op == 5:                                       # bye
        break
    elif op == 1:                                     # reset: first, parameters, states
        theta, v, y = a[1:3], a[3], []
    elif op == 2:                                     # step: inputs, forces; gives outputs, states
        y, v = [v], step(theta, v, *a)
        y.append(v)
    elif op == 3:                                     # rollout: first, samples, parameters, states, rows
        theta, v, y = a[2:4], a[4], []
        for k in range(5, count, 2):
            y.append(v)
            v = step(theta, v, a[k], a[k + 1])
        y.append(v)
    elif op == 4:                                     # measure: inputs; gives outputs
        y = [v]
    answer.write(struct.pack(f"<III{len(y)}d", op, 1, len(y), *y))
    answer.flush()
