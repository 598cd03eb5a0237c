# The wire protocol from PROTOCOL.md alone: an encoder and a decoder that share no code with the project.
import struct
def crc(b):
    c=0xffff
    for x in b:
        c^=x<<8
        for _ in range(8): c=((c<<1)^0x1021)&0xffff if c&0x8000 else (c<<1)&0xffff
    return c
def cobs(b):
    out=bytearray(); blk=bytearray()
    for x in b+b'\0':
        if x==0: out.append(len(blk)+1); out+=blk; blk=bytearray()
        else: blk.append(x)
    return bytes(out)
def uncobs(b):
    out=bytearray(); i=0
    while i<len(b):
        n=b[i]; out+=b[i+1:i+n]; i+=n
        if i<len(b): out.append(0)
    return bytes(out)
def frame(t,body): c=bytes([t])+body; return cobs(c+struct.pack('<H',crc(c)))+b'\0'
def hello(ver=1,boot=1,ts=30000,short=1000,cpr=720,mv=4500,fields=0,maxseg=2688,name=b'fake',magic=b'MLAB'):
    return frame(1,magic+struct.pack('<BBBIIHIHBH',ver,1,0,boot,ts,short,cpr,mv,fields,maxseg)+name)
def data(seq,t,counts,mv,flags=0): return frame(4,struct.pack('<HIihB',seq&0xffff,t&0xffffffff,((counts+2**31)%2**32)-2**31,mv,flags))
def end(taken,dropped=0,reason=0): return frame(5,struct.pack('<IIB',taken,dropped,reason))
def ack(t,d=0): return frame(2,struct.pack('<BH',t,d))
def nak(t,r): return frame(3,bytes([t,r]))
class Dec:
    def __init__(s): s.b=bytearray()
    def push(s,x):
        r=[]
        for c in x:
            if c==0:
                if s.b:
                    f=uncobs(bytes(s.b))
                    if len(f)>=3 and crc(f[:-2])==struct.unpack('<H',f[-2:])[0]: r.append((f[0],f[1:-2]))
                s.b=bytearray()
            else: s.b.append(c)
        return r
assert hello(boot=0x01020304,ts=3000,short=1500,cpr=720,mv=4500,fields=2,maxseg=1736,name=b'uno',ver=1)
assert data(258,4294964296,-720,4500,1).hex()=='11040201 48f4ffff 30fdffff 94110131a600'.replace(' ',''),data(258,4294964296,-720,4500,1).hex()
assert end(1334,0,0) or 1
