"""ltbw: Gappa scripts for the semi-static filters, scale free, with underflow terms.

Licence: MIT OR Apache-2.0. Run by `cargo xtask prove`. Writes, into the current folder, one script
per predicate whose goal is below the constant that the code uses (46.1 u for orient3d, 1106 u for
insphere, which also cover the rounding of the bound itself). With u = 2^-53.

The scripts state the standard model of rounding as hypotheses, without *_rel operators, so that
Gappa's Coq back-end accepts them. Every computed value is a free real variable v with the
hypotheses  v_m -/ (exact operation on computed arguments) in [-u, u]  and |v - v_m| <= eta (for
products only). All x-quantities are divided by mx, y by my, z by mz (the largest absolute rounded
differences), so that |rounded difference| <= 1.
"""
U="1b-53"
def semi(which, eta=None, goal="in ?", order="shewchuk"):
    pts,base=("abc","d") if which=="o3d" else ("abcd","e")
    defs=[];hyp=[]
    for p in pts:
        for k in "xyz":
            v=f"{p}{base}{k}"
            hyp+= [f"|{v}| <= 1", f"|{v} - {v}_e| <= {U}"]
    def op(n,o,a,b):
        hyp.append(f"{n} -/ ({a} {o} {b}) in [-{U},{U}]")
        defs.append(f"{n}_e = {a}_e {o} {b}_e;"); return n
    def mul(n,a,b,d):
        if eta is None: return op(n,"*",a,b)
        hyp.append(f"{n}_m -/ ({a} * {b}) in [-{U},{U}]"); hyp.append(f"|{n} - {n}_m| <= {eta[d]}")
        defs.append(f"{n}_e = {a}_e * {b}_e;"); return n
    add=lambda n,a,b: op(n,"+",a,b)
    sub=lambda n,a,b: op(n,"-",a,b)
    def minor(n,a,b,c,d): mul(n+"p",a,b,2); mul(n+"q",c,d,2); return sub(n,n+"p",n+"q")
    if which=="o3d":
        minor("m1","bdx","cdy","cdx","bdy"); minor("m2","cdx","ady","adx","cdy"); minor("m3","adx","bdy","bdx","ady")
        mul("t1","adz","m1",3); mul("t2","bdz","m2",3); mul("t3","cdz","m3",3)
        add("s1","t1","t2"); add("det","s1","t3")
    else:
        minor("ab","aex","bey","bex","aey"); minor("bc","bex","cey","cex","bey"); minor("cd","cex","dey","dex","cey")
        minor("da","dex","aey","aex","dey"); minor("ac","aex","cey","cex","aey"); minor("bd","bex","dey","dex","bey")
        def tri(n,z1,m1,s2,z2,m2,z3,m3):
            mul(n+"1",z1,m1,3); mul(n+"2",z2,m2,3); mul(n+"3",z3,m3,3)
            (sub if s2=="-" else add)(n+"s",n+"1",n+"2"); return add(n,n+"s",n+"3")
        tri("abc","aez","bc","-","bez","ac","cez","ab"); tri("bcd","bez","cd","-","cez","bd","dez","bc")
        tri("cda","cez","da","+","dez","ac","aez","cd"); tri("dab","dez","ab","+","aez","bd","bez","da")
        for p in "abcd":
            for k in "xyz":   # lift variables are normalised by m = max(mx,my,mz), hence separate names
                v=f"{p}v{k}"; hyp.extend([f"|{v}| <= 1", f"|{v} - {v}_e| <= {U}"]); mul(f"{p}l{k}",v,v,2)
            add(f"{p}ls",f"{p}lx",f"{p}ly"); add(f"{p}l",f"{p}ls",f"{p}lz")
        mul("w1","dl","abc",5); mul("w2","cl","dab",5); mul("w3","bl","cda",5); mul("w4","al","bcd",5)
        if order=="shewchuk": sub("v1","w1","w2"); sub("v2","w3","w4"); add("det","v1","v2")
        else: sub("v1","w1","w2"); add("v2","v1","w3"); sub("det","v2","w4")   # CGAL / FPG: left-to-right sum of 4
    return "\n".join(defs)+"\n{ "+" /\\\n  ".join(hyp)+"\n -> |det - det_e| "+goal+" }\n"
if __name__ == "__main__":
    # Underflow of products of degree 2, 3 and 5, relative to the magnitudes divided out.
    eta = {2: "1b-300", 3: "1b-200", 5: "1b-100"}
    with open("o3d_semistatic.g", "w") as f:
        f.write(semi("o3d", eta, goal="<= 47111b-63"))
    with open("isp_semistatic.g", "w") as f:
        f.write(semi("isp", eta, goal="<= 1131000b-63"))
