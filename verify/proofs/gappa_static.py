"""ltbw: Gappa scripts for the static filters, |coordinate| <= 1, binary64 with subnormals.

Licence: MIT OR Apache-2.0. Run by `cargo xtask prove`. Writes, into the current folder, one script
per predicate whose goal is the bound that the code uses: Gappa succeeds only if it holds.
orient3d: 192 u. insphere: 21120 u. With u = 2^-53.
"""
import re


def o3d_abs(B="1", fmt="float<ieee_64, ne>", goal="in ?"):
    s=f"@rnd = {fmt};\n"
    for p in "abcd":
        for k in "xyz": s+=f"{p}{k} = rnd({p}{k}_);\n"
    for p in "abc":
        for k in "xyz": s+=f"{p}d{k} rnd= {p}{k} - d{k};\n"
    s+="""det rnd= (adz*(bdx*cdy - cdx*bdy) + bdz*(cdx*ady - adx*cdy)) + cdz*(adx*bdy - bdx*ady);
edet = ((az-dz)*((bx-dx)*(cy-dy) - (cx-dx)*(by-dy))
      + (bz-dz)*((cx-dx)*(ay-dy) - (ax-dx)*(cy-dy)))
      + (cz-dz)*((ax-dx)*(by-dy) - (bx-dx)*(ay-dy));
"""
    h=" /\\ ".join(f"{p}{k} in [-{B},{B}]" for p in "abcd" for k in "xyz")
    s+="{ "+h+"\n -> det - edet "+goal+" }\n"
    return s
def isp_abs(B="1", fmt="float<ieee_64, ne>", goal="in ?"):
    s=f"@rnd = {fmt};\n"
    for p in "abcde":
        for k in "xyz": s+=f"{p}{k} = rnd({p}{k}_);\n"
    for p in "abcd":
        for k in "xyz":
            s+=f"{p}e{k} rnd= {p}{k} - e{k};\n"
            s+=f"{p}{k}x = {p}{k} - e{k};\n"
    body="""
ab{r} {o} aex*bey - bex*aey;
bc{r} {o} bex*cey - cex*bey;
cd{r} {o} cex*dey - dex*cey;
da{r} {o} dex*aey - aex*dey;
ac{r} {o} aex*cey - cex*aey;
bd{r} {o} bex*dey - dex*bey;
abc{r} {o} (aez*bc{r} - bez*ac{r}) + cez*ab{r};
bcd{r} {o} (bez*cd{r} - cez*bd{r}) + dez*bc{r};
cda{r} {o} (cez*da{r} + dez*ac{r}) + aez*cd{r};
dab{r} {o} (dez*ab{r} + aez*bd{r}) + bez*da{r};
al{r} {o} (aex*aex + aey*aey) + aez*aez;
bl{r} {o} (bex*bex + bey*bey) + bez*bez;
cl{r} {o} (cex*cex + cey*cey) + cez*cez;
dl{r} {o} (dex*dex + dey*dey) + dez*dez;
det{r} {o} (dl{r}*abc{r} - cl{r}*dab{r}) + (bl{r}*cda{r} - al{r}*bcd{r});
"""
    s+=body.replace("{r}","").replace("{o}","rnd=")
    e=body.replace("{r}","_e").replace("{o}","=")
    e=re.sub(r"\b([abcd])e([xyz])\b", r"\1\2x", e)
    s+=e
    h=" /\\ ".join(f"{p}{k} in [-{B},{B}]" for p in "abcde" for k in "xyz")
    s+="{ "+h+"\n -> det - det_e "+goal+" }\n"
    return s
if __name__ == "__main__":
    with open("o3d_static.g", "w") as f:
        f.write(o3d_abs(goal="in [-192b-53, 192b-53]"))
    with open("isp_static.g", "w") as f:
        f.write(isp_abs(goal="in [-21120b-53, 21120b-53]"))
