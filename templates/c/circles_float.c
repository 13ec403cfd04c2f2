/* Sines and cosines of n angles, within 1.5 units in the last place up to LARGEST_ANGLE.
 *
 * x = k pi/2 + r with pi/2 in four parts, of which k times the first three are exact; polynomials in r; the last two
 * bits of k, read from the sum that rounds it, choose sine or cosine and the signs.
 */
INLINE void circles(size_t n, const float *restrict x, float *restrict sine, float *restrict cosine)
{
    int large = 0;
    for (size_t i = 0; i < n; i++)
        large |= !(fabsf(x[i]) <= LARGEST_ANGLE);
    if (large) {
        for (size_t i = 0; i < n; i++) {
            sine[i] = sinf(x[i]);
            cosine[i] = cosf(x[i]);
        }
        return;
    }
    for (size_t i = 0; i < n; i++) {
        const float rounder = 0x1.8p23f;
        const float rounded = x[i]*0x1.45f306p-1f + rounder;
        const float k = rounded - rounder;
        const float t = (x[i] - k*0x1.92p+0f) - k*0x1.fb4p-12f, u = k*0x1.444p-24f, v = t - u;
        const float r = v + (((t - v) - u) - k*0x1.68c234p-39f);
        const float z = r*r;
        const float s = r + r*z*(-0.166666667f + z*(0.00833333188f + z*(-0.00019840087f + z*2.724994e-06f)));
        const float c = 1.0f - (0.5f*z - z*z*(0.0416666647f + z*(-0.00138883031f + z*2.4547990e-05f)));
        uint32_t quarter, bits_s, bits_c;
        memcpy(&quarter, &rounded, sizeof quarter);
        memcpy(&bits_s, &s, sizeof bits_s);
        memcpy(&bits_c, &c, sizeof bits_c);
        const uint32_t exchange = (0 - (quarter & 1)) & (bits_s ^ bits_c);
        bits_s ^= exchange ^ ((quarter & 2) << 30);
        bits_c ^= exchange ^ (((quarter + 1) & 2) << 30);
        memcpy(&sine[i], &bits_s, sizeof bits_s);
        memcpy(&cosine[i], &bits_c, sizeof bits_c);
    }
}
