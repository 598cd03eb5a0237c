/* Random bytes for the Windows program under wine 8, whose bcryptprimitives.dll lacks ProcessPrng: forwarded to what
 * advapi32 exports under the name of SystemFunction036 (RtlGenRandom). Only tests use it. */
__declspec(dllimport) unsigned char __stdcall SystemFunction036(void *bytes, unsigned long length);

__declspec(dllexport) int __stdcall ProcessPrng(unsigned char *bytes, unsigned long long length)
{
    return SystemFunction036(bytes, (unsigned long)length);
}
